// SPDX-License-Identifier: BSD-3-Clause
// Legs whose encoders have the sole askew by the same in every recording.
#include "diagnosis/floating/checks/leg_zeros.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/unit/diagnosis/legged/biped.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr int kRows = 30;  // of a recording
constexpr int kRoll = 0, kPitch = 1;
using Angles = std::vector<double>;  // [rad] by recording

// The foot's joints are all about y: a zero of any of them pitches the sole back.
ChannelRows make_rows(int axis, const char* foot, const Angles& tilt, const std::vector<int>& columns) {
  ChannelRows rows;
  rows.info = {{EquationKind::kTilt, axis}, "/joint_states", "rad", "foot", foot};
  rows.columns = columns;
  for (int i = 0; i < kRows * static_cast<int>(tilt.size()); ++i) {
    rows.recording.push_back(i / kRows);
    rows.y.push_back(tilt[static_cast<size_t>(i / kRows)] + 0.001 * (i % 3 - 1));
    for (size_t k = 0; k < columns.size(); ++k) rows.x.push_back(axis == kPitch ? -1.0 : 0.0);
  }
  return rows;
}

std::vector<Finding> find_zeros(const Angles& left, const Angles& right) {
  const LeggedLog log = make_legged_log(make_biped({}), Half::kEven);
  const ColumnLayout layout(log);
  const Angles level(left.size(), 0.0);
  const auto columns = [&](int first) {
    std::vector<int> out;
    for (int j = first; j < first + 3; ++j) out.push_back(layout.joint(j, kOffsetColumn));
    return out;
  };
  CheckResult out;
  check_leg_zeros(log,
                  {make_rows(kRoll, "l_foot", level, columns(0)), make_rows(kPitch, "l_foot", left, columns(0)),
                   make_rows(kRoll, "r_foot", level, columns(3)), make_rows(kPitch, "r_foot", right, columns(3))},
                  layout, &out);
  return out.findings;
}

TEST(LegZeros, AnyJointOfTheLegMayHaveTheZeroThatTiltsItsSole) {
  const std::vector<Finding> found = find_zeros({0.028, 0.032, 0.030}, {0.001, -0.003, 0.002});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].effect, "joint_offset");
  EXPECT_EQ(found[0].grade, Grade::kAmbiguous);
  EXPECT_EQ(found[0].where.at("joint").get<std::string>().rfind("l_", 0), 0u);
  EXPECT_NEAR(found[0].parameters[0].value[0], -0.030, 0.001);
  ASSERT_EQ(found[0].alternatives.size(), 2u);
  EXPECT_NEAR(found[0].alternatives[0].parameters[0].value[0], -0.030, 0.001);
}

TEST(LegZeros, WhatTiltsBothSolesOrOtherwiseInEachRecordingIsNoZeroOfALeg) {
  EXPECT_TRUE(find_zeros({0.028, 0.032, 0.030}, {0.027, 0.030, 0.031}).empty());
  EXPECT_TRUE(find_zeros({0.030, -0.020, 0.030}, {0.001, -0.003, 0.002}).empty());
  EXPECT_TRUE(find_zeros({0.008, 0.008, 0.008}, {0.0, 0.0, 0.0}).empty());
}

// Significant at 95 %, but six joints were asked.
TEST(LegZeros, AMeanOfThreeErrorsOrLessIsNoZero) {
  EXPECT_TRUE(find_zeros({0.022, 0.007, 0.016, 0.015}, {0.0, 0.0, 0.0, 0.0}).empty());
  EXPECT_EQ(find_zeros({0.018, 0.012, 0.016, 0.015}, {0.0, 0.0, 0.0, 0.0}).size(), 1u);
}

}  // namespace
}  // namespace hrp::diagnosis::floating
