// SPDX-License-Identifier: BSD-3-Clause
// A run that has to end well, and what its log holds: equal runs have equal digests.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/process/server_set.h"

namespace hrp::test {

// `during`: while it runs; may be empty. Overwrites the log of an earlier run of this name: they come again in other
// suites.
inline std::map<std::string, TopicDigest> run_and_digest(const std::string& name, const std::string& scenario,
                                                         std::vector<std::string> options,
                                                         const std::function<void(ServerSet&)>& during = nullptr) {
  options.insert(options.begin(), {scenario, "--force"});
  ServerSet set(name, options);
  if (during) during(set);
  EXPECT_EQ(set.wait(), 0) << set.output();
  return digest_log(set.log());
}

}  // namespace hrp::test
