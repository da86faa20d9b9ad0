// SPDX-License-Identifier: BSD-3-Clause
// Soles that the encoders have askew while they stand.
#include "diagnosis/floating/checks/sole_check.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace hrp::diagnosis::floating {
namespace {

const std::vector<std::string> kNames = {"walk.csv", "sway.csv"};

// Thirty rows of each recording, around a tilt [rad].
ChannelRows make_rows(int axis, double walk, double sway) {
  ChannelRows rows;
  rows.info = {{EquationKind::kTilt, axis}, "/joint_states", "rad", "foot", "l_foot"};
  for (int i = 0; i < 60; ++i) {
    rows.recording.push_back(i < 30 ? 0 : 1);
    rows.y.push_back((i < 30 ? walk : sway) + 0.002 * (i % 3 - 1));
  }
  return rows;
}

CheckResult check(double walk, double sway) {
  CheckResult out;
  check_soles({make_rows(0, 0.001, 0.0), make_rows(1, walk, sway)}, kNames, &out);
  return out;
}

TEST(SoleCheck, ASoleThatIsAskewIsSaidWithItsAngles) {
  const CheckResult found = check(0.020, 0.022);
  ASSERT_EQ(found.remaining.size(), 1u);
  EXPECT_NEAR(found.remaining[0].before, 0.022, 1e-4);
  EXPECT_NE(found.remaining[0].statement.find("pitch 22.0 mrad in sway.csv."), std::string::npos)
      << found.remaining[0].statement;
}

TEST(SoleCheck, AnglesThatDifferByRecordingAreSaidOfBoth) {
  const std::string text = check(-0.005, 0.022).remaining.at(0).statement;
  EXPECT_NE(text.find("pitch 22.0 mrad in sway.csv and by roll 1.0, pitch -5.0 mrad in walk.csv"), std::string::npos)
      << text;
}

TEST(SoleCheck, HalfADegreeIsNoMismatch) { EXPECT_TRUE(check(-0.005, 0.008).remaining.empty()); }

}  // namespace
}  // namespace hrp::diagnosis::floating
