// SPDX-License-Identifier: BSD-3-Clause
// Joints that something stops within their travel.
#include <gtest/gtest.h>

#include "tests/unit/diagnosis/torque_verdicts.h"

namespace hrp::diagnosis {
namespace {

constexpr double kStop = 0.45;        // [rad] of the elbow, near the end of its travel
constexpr double kStiffness = 150.0;  // [N m/rad]

Experiment make_arm(const std::string& name) {
  Experiment e = simulate_arm(name, make_arm_drives());
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) forget_commands(&r);
  return e;
}

// The same motion needs that much more effort beyond the stop.
Experiment make_stopped(const std::string& name) {
  Experiment e = make_arm(name);
  for (Recording& r : e.recordings) {
    const std::vector<double>& q = r.joints[kElbow].signal[static_cast<int>(Quantity::kPosition)];
    std::vector<double>& effort = r.joints[kElbow].signal[static_cast<int>(Quantity::kEffort)];
    for (size_t k = 0; k < q.size(); ++k) effort[k] += kStiffness * std::max(0.0, q[k] - kStop);
  }
  return e;
}

bool warns_of_stop(const TorqueData& data) {
  return std::any_of(data.warnings.begin(), data.warnings.end(),
                     [](const std::string& w) { return w.find("something stops it") != std::string::npos; });
}

// Masses and friction stood for it before.
TEST(Stops, SamplesBeyondThemAreLeftOutSoThatTheFrictionIsRight) {
  const Experiment e = make_stopped("stops");
  EXPECT_TRUE(warns_of_stop(make_torque_data(e)));
  const TorqueVerdict verdict = judge_torque(e, 1);
  const Finding* friction = find(verdict, "coulomb_friction", "elbow");
  ASSERT_NE(friction, nullptr);
  EXPECT_NEAR(friction->parameters[0].value[0], 0.8, 3.0 * friction->parameters[0].std[0]) << friction->statement;
  EXPECT_EQ(find(verdict, "com_error", "fore"), nullptr);
}

TEST(Stops, ArmsThatMoveFreelyHaveNone) {
  EXPECT_FALSE(warns_of_stop(make_torque_data(make_arm("stops_none"))));
  Hypothesis sprung = make_arm_drives();
  sprung.push_back({EffectId::kSpring, kElbow, {20.0, 0.2}});
  sprung.push_back({EffectId::kPayload, kFore, {1.0, 0.3, 0.0, 0.0, 0.0}});
  Experiment e = simulate_arm("stops_sprung", sprung);
  e.scenario.drive = "effort";
  EXPECT_FALSE(warns_of_stop(make_torque_data(e)));
}

}  // namespace
}  // namespace hrp::diagnosis
