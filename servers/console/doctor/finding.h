// SPDX-License-Identifier: BSD-3-Clause
// What hrp-doctor says: one line a check, with the mend where something is wrong.
#pragma once

#include <string>
#include <vector>

namespace hrp {

struct Finding {
  std::string what;  // "interface"
  bool problem = false;
  std::string says;
  std::string mend;  // of a problem: what to do
};

using Findings = std::vector<Finding>;

inline Finding make_ok(std::string what, std::string says) { return {std::move(what), false, std::move(says), ""}; }
inline Finding make_problem(std::string what, std::string says, std::string mend) {
  return {std::move(what), true, std::move(says), std::move(mend)};
}

}  // namespace hrp
