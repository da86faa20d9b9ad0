// SPDX-License-Identifier: BSD-3-Clause
// What every real drive has is listed where friction shows a drive, even if its size is known badly.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/torque/findings.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

std::optional<Finding> find_at_elbow(const Experiment& e, EffectId effect) {
  for (const Finding& f : judge_torque(e, 1).evidence.findings) {
    if (f.effect == get_effect(effect).name && f.where.begin().value() == "elbow") return f;
  }
  return std::nullopt;
}

// The rotor that is found at an elbow whose dry friction of 1.5 N m varies by 0.6 N m over the position.
std::optional<Finding> find_rotor(const std::string& name, double rotor) {
  Hypothesis hidden{{EffectId::kViscous, kElbow, {0.4}}, {EffectId::kCoulomb, kElbow, {1.5, 0.0, 5e-4}}};
  if (rotor > 0.0) hidden.push_back({EffectId::kRotorInertia, kElbow, {rotor}});
  Experiment e = make_simulated_experiment(name, kArm, kArmJoints, hidden);
  for (Recording& r : e.recordings) {
    JointColumns& joint = r.joints[1];
    for (size_t k = 0; k < r.size(); ++k)
      joint.signal[2][k] += 0.6 * std::sin(9.0 * joint.signal[0][k]) * std::tanh(joint.signal[1][k] / 0.05);
  }
  return find_at_elbow(e, EffectId::kRotorInertia);
}

// Before, the model had this rotor and predicted held-out recordings better with it, but no finding said so.
TEST(TorqueExpected, ASmallRotorBesideUnevenFrictionIsListedAsAmbiguous) {
  constexpr double kRotor = 0.09;
  const std::optional<Finding> f = find_rotor("expected_rotor", kRotor);
  ASSERT_TRUE(f.has_value());
  EXPECT_EQ(f->grade, Grade::kAmbiguous) << f->statement;
  EXPECT_EQ(f->alternatives.empty(), f->statement.find("It is ambiguous because") != std::string::npos) << f->statement;
  EXPECT_NEAR(f->parameters[0].value[0], kRotor, kNinetyFive * f->parameters[0].std[0]) << f->statement;
}

TEST(TorqueExpected, UnevenFrictionAloneShowsNoRotor) { EXPECT_FALSE(find_rotor("expected_none", 0.0).has_value()); }

// Grease that warms up: dry friction falls from 2.6 to 0.4 N m in each recording. The change is a bound of the value.
// As a difference between parts of the recordings it would count twice, and the interval would contain no friction.
TEST(TorqueExpected, FrictionThatFadesIsSupportedWithTheRangeOfItsValues) {
  constexpr double kLevel = 1.5, kFade = 1.1;  // [N m]
  Experiment e = make_simulated_experiment(
      "expected_fade", kArm, kArmJoints,
      {{EffectId::kViscous, kElbow, {0.4}}, {EffectId::kCoulomb, kElbow, {kLevel, 0.0, 5e-4}}});
  for (Recording& r : e.recordings) {
    JointColumns& joint = r.joints[1];
    for (size_t k = 0; k < r.size(); ++k)
      joint.signal[2][k] +=
          kFade * (1.0 - 2.0 * (r.time[k] - r.time[0]) / r.duration()) * std::tanh(joint.signal[1][k] / 0.01);
  }
  const std::optional<Finding> f = find_at_elbow(e, EffectId::kCoulomb);
  ASSERT_TRUE(f.has_value());
  EXPECT_EQ(f->grade, Grade::kSupported) << f->statement;
  const double value = f->parameters[0].value[0], width = kNinetyFive * f->parameters[0].std[0];
  EXPECT_GT(value - width, 0.0) << f->statement;
  EXPECT_LT(value - width, kLevel - kFade) << f->statement;
  EXPECT_GT(value + width, kLevel + kFade) << f->statement;
}

}  // namespace
}  // namespace hrp::diagnosis
