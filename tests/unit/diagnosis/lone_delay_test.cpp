// SPDX-License-Identifier: BSD-3-Clause
// Late commands of one servo that logs positions only, against friction and rotor in their place.
#include <gtest/gtest.h>

#include <algorithm>

#include "diagnosis/evidence/lone_delay.h"
#include "tests/unit/diagnosis/torque_verdicts.h"

namespace hrp::diagnosis {
namespace {

// Only positions were recorded, with steps of `count` [rad].
Experiment make_position_log(const std::string& name, const Hypothesis& hidden, double count) {
  Experiment e = make_simulated_experiment(name, kArm, kArmJoints, hidden);
  for (Recording& r : e.recordings) {
    for (JointColumns& joint : r.joints) {
      joint.signal[1].clear();
      joint.signal[2].clear();
      for (double& q : joint.signal[0]) q = count * std::round(q / count);
    }
  }
  return e;
}

// With friction in both joints.
TorqueVerdict judge_late_elbow(const std::string& name, double delay) {
  const Hypothesis hidden{{EffectId::kCoulomb, kShoulder, {1.5, 0.0, 5e-4}},
                          {EffectId::kCoulomb, kElbow, {0.8, 0.0, 5e-4}},
                          {EffectId::kDelay, kElbow, {delay}}};
  return judge_torque(make_position_log(name, hidden, 2e-3), 1);
}

TEST(LoneDelay, IsSupportedWhereFrictionAndRotorLeaveTwiceAsMuch) {
  const TorqueVerdict verdict = judge_late_elbow("lone_delay_clear", 0.03);
  const Finding* f = find(verdict, "command_delay", "elbow");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->grade, Grade::kSupported) << f->statement;
  EXPECT_NEAR(f->parameters[0].value[0], 0.03, 2.0 * f->parameters[0].std[0]) << f->statement;
}

// Two fifths of the delay: what friction and rotor cannot do falls with its square, and is lost beside the encoder's
// steps.
TEST(LoneDelay, ThatFrictionAndRotorFitNearlyAsWellNamesThem) {
  const TorqueVerdict verdict = judge_late_elbow("lone_delay_little", 0.012);
  const Finding* f = find(verdict, "command_delay", "elbow");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->grade, Grade::kAmbiguous) << f->statement;
  EXPECT_TRUE(std::any_of(f->alternatives.begin(), f->alternatives.end(),
                          [](const Alternative& a) { return a.effect == "viscous_friction"; }));
}

// Viscous friction of both joints, whose servos have the same kp of 200 N m/rad.
TorqueVerdict judge_viscous(const std::string& name, double shoulder, double elbow) {
  const Hypothesis hidden{{EffectId::kCoulomb, kShoulder, {1.5, 0.0, 5e-4}},
                          {EffectId::kCoulomb, kElbow, {0.8, 0.0, 5e-4}},
                          {EffectId::kViscous, kShoulder, {shoulder}},
                          {EffectId::kViscous, kElbow, {elbow}}};
  return judge_torque(make_position_log(name, hidden, 1e-4), 1);
}

TEST(LoneDelay, ViscousFrictionInOneProportionToTheGainsMayBeOneDelay) {
  const TorqueVerdict verdict = judge_viscous("viscous_of_one_delay", 3.0, 2.8);
  for (const char* joint : {"shoulder", "elbow"}) {
    const Finding* f = find(verdict, "viscous_friction", joint);
    ASSERT_NE(f, nullptr);
    EXPECT_EQ(f->grade, Grade::kAmbiguous) << f->statement;
    EXPECT_TRUE(std::any_of(f->alternatives.begin(), f->alternatives.end(),
                            [](const Alternative& a) { return a.effect == "command_delay"; }));
  }
}

TEST(LoneDelay, ViscousFrictionThatDiffersIsNoDelayOfAllCommands) {
  const Finding* f = find(judge_viscous("viscous_differs", 3.0, 0.8), "viscous_friction", "shoulder");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->grade, Grade::kSupported) << f->statement;
}

}  // namespace
}  // namespace hrp::diagnosis
