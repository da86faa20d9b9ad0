// SPDX-License-Identifier: BSD-3-Clause
// Gears that give, by the torque along the encoders: the links swing behind them, near their resonance.
#include <gtest/gtest.h>

#include "diagnosis/evidence/soft_joints.h"
#include "diagnosis/measurement/soft_gears.h"
#include "diagnosis/measurement/torque/residual.h"
#include "tests/unit/diagnosis/torque_verdicts.h"

namespace hrp::diagnosis {
namespace {

constexpr double kStiffness = 100.0, kDamping = 1.0, kRotor = 0.6;  // [N m/rad], [N m s/rad], [kg m^2]

// The arm's links and the shoulder's gear swing at 2.4 Hz, which its drives and their dry friction excite.
Hypothesis make_soft_shoulder() {
  return {{EffectId::kViscous, kShoulder, {0.3}},
          {EffectId::kCoulomb, kShoulder, {0.3, 0.0, 5e-4}},
          {EffectId::kElasticity, kShoulder, {kStiffness, kDamping, kRotor}},
          {EffectId::kViscous, kElbow, {0.1}},
          {EffectId::kCoulomb, kElbow, {0.15, 0.0, 5e-4}},
          {EffectId::kRotorInertia, kElbow, {0.3}}};
}

Experiment make_soft_arm(const std::string& name) {
  Experiment e = make_simulated_experiment(name, kArm, kArmJoints, make_soft_shoulder());
  add_texture(0.03, &e);  // so that no law explains it to the noise
  return e;
}

TEST(SoftGears, ASoftShoulderIsNamedWithItsStiffnessAndNoGainOrMassStandsInForIt) {
  const TorqueVerdict verdict = judge_torque(make_soft_arm("soft_shoulder"), 1);
  const Finding* f = find(verdict, "joint_elasticity", "shoulder");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->grade, Grade::kSupported) << f->statement;
  EXPECT_NEAR(f->parameters[0].value[0], kStiffness, 1.96 * f->parameters[0].std[0]) << f->statement;
  for (const Finding& other : verdict.evidence.findings) {
    EXPECT_NE(other.family, get_family_name(EffectFamily::kMass)) << other.statement;
    EXPECT_NE(other.family, get_family_name(EffectFamily::kGain)) << other.statement;
  }
}

TEST(SoftGears, TheSimulatedRobotGetsTheRotorBehindTheSoftGear) {
  const TorqueVerdict verdict = judge_torque(make_soft_arm("soft_model"), 1);
  const auto soft = std::find_if(verdict.model.begin(), verdict.model.end(),
                                 [](const Effect& e) { return e.id == EffectId::kElasticity; });
  ASSERT_NE(soft, verdict.model.end());
  EXPECT_NEAR(soft->p[2], kRotor, 0.1 * kRotor);  // a tenth: the texture of friction
  for (const Effect& e : verdict.model) EXPECT_FALSE(e.id == EffectId::kRotorInertia && e.place.index == kShoulder);
}

// Between clear and nothing: a compliance is listed only if it differs from none.
TEST(SoftGears, ANotedGearWhoseComplianceMayBeZeroIsNotListed) {
  const Experiment e = simulate_arm("noted_gear", {});
  for (const bool told : {true, false}) {
    SoftGear gear;
    gear.joint = kShoulder;
    gear.give = 0.01;
    gear.std = told ? 0.004 : 0.006;
    gear.left = 0.6;
    std::vector<Finding> findings;
    Hypothesis model;
    add_soft_gear(e, gear, EffortSource::kRecorded, &findings, &model);
    EXPECT_EQ(findings.size(), told ? 1u : 0u);
  }
}

// The twist by a torque that nobody measured is a part of command and position, as by another law of the servo.
TEST(SoftGears, WithoutARecordedEffortTheServosLawMayBeAnotherOne) {
  const Experiment e = simulate_arm("unmeasured_gear", {});
  for (EffortSource source : {EffortSource::kRecorded, EffortSource::kServoLaw}) {
    SoftGear gear;
    gear.joint = kShoulder;
    gear.give = 0.01;
    gear.std = 1e-4;
    gear.left = 0.2;
    gear.applied = true;
    std::vector<Finding> findings;
    Hypothesis model;
    add_soft_gear(e, gear, source, &findings, &model);
    ASSERT_EQ(findings.size(), 1u);
    const bool measured = source == EffortSource::kRecorded;
    EXPECT_EQ(findings[0].grade, measured ? Grade::kSupported : Grade::kAmbiguous);
    EXPECT_EQ(findings[0].alternatives.empty(), measured);
  }
}

TEST(SoftGears, ARigidArmHasNoGearThatGives) {
  Experiment e = simulate_arm("rigid_arm", make_arm_drives());
  add_texture(0.1, &e);
  EXPECT_FALSE(find_soft_gear(make_torque_data(e)).has_value());
}

// A model with the soft gear predicts efforts along the links' motion, which no log contains.
TEST(SoftGears, EffortsAlongTheMotionBehindASoftGearAreThoseOfTheDrive) {
  const Experiment e = make_soft_arm("soft_efforts");
  const TorqueData data = make_torque_data(e);
  Hypothesis rigid = make_soft_shoulder();
  rigid[2] = {EffectId::kRotorInertia, kShoulder, {kRotor}};
  const std::vector<double> with = calc_torque_residuals(data, make_plant(e, make_soft_shoulder()), true),
                            without = calc_torque_residuals(data, make_plant(e, rigid), true);
  // Less than half of the squares: the simulated arm starts with its gear untwisted and swings, which no log shows.
  EXPECT_LT(with[kShoulder], 0.7 * without[kShoulder]);
  EXPECT_LT(with[kElbow], without[kElbow]);
}

}  // namespace
}  // namespace hrp::diagnosis
