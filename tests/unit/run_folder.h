// SPDX-License-Identifier: BSD-3-Clause
// A folder of runs of the test's own, so that runs of this machine are not seen.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <string>

namespace hrp::test {

class OwnRunFolder : public ::testing::Test {
 protected:
  OwnRunFolder() {
    char name[] = "/tmp/hrp-runs-test-XXXXXX";
    parent_ = mkdtemp(name);
    setenv("XDG_RUNTIME_DIR", parent_.c_str(), 1);
    folder_ = parent_ + "/openhrp-dds";
  }
  ~OwnRunFolder() override { std::filesystem::remove_all(parent_); }
  std::string parent_, folder_;
};

}  // namespace hrp::test
