// SPDX-License-Identifier: BSD-3-Clause
// What every real drive has is listed where friction shows a drive, even if its size is known badly.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/torque_findings.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

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
  for (const Finding& f : judge_torque(e, 1).evidence.findings) {
    if (f.effect == get_effect(EffectId::kRotorInertia).name && f.where.begin().value() == "elbow") return f;
  }
  return std::nullopt;
}

// Before, the model had this rotor and predicted held-out recordings better with it, but no finding said so.
TEST(TorqueExpected, ASmallRotorBesideUnevenFrictionIsListedAsAmbiguous) {
  constexpr double kRotor = 0.09;
  const std::optional<Finding> f = find_rotor("expected_rotor", kRotor);
  ASSERT_TRUE(f.has_value());
  EXPECT_EQ(f->grade, Grade::kAmbiguous) << f->statement;
  EXPECT_NEAR(f->parameters[0].value[0], kRotor, kNinetyFive * f->parameters[0].std[0]) << f->statement;
}

TEST(TorqueExpected, UnevenFrictionAloneShowsNoRotor) { EXPECT_FALSE(find_rotor("expected_none", 0.0).has_value()); }

}  // namespace
}  // namespace hrp::diagnosis
