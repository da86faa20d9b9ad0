// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/base/diagnostics.h"

namespace hrp {

// For the end of a complaint about a mistyped word: "; did you mean 'elbow'?", or `otherwise` where none is near.
inline std::string suggest(const std::string& word, const std::vector<std::string>& candidates,
                           const std::string& otherwise = "") {
  const std::string nearest = find_nearest(word, candidates);
  return nearest.empty() ? otherwise : "; did you mean '" + nearest + "'?";
}

}  // namespace hrp
