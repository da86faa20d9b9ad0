// SPDX-License-Identifier: BSD-3-Clause
// The table of effects: what every row promises to its readers.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "common/effects/effect_info.h"
#include "common/effects/effect_target.h"

namespace hrp {
namespace {

JointLaws apply_to(JointLaws laws, EffectId id, std::vector<double> values) {
  values.resize(get_effect(id).parameters.size(), std::nan(""));
  EffectTarget target;
  target.joint = &laws;
  get_effect(id).apply(values.data(), target);
  return laws;
}

TEST(EffectTable, HasOneRowForEveryNameWithFamilyAndSentence) {
  std::set<std::string> names;
  for (const EffectInfo& effect : list_effects()) {
    EXPECT_TRUE(names.insert(effect.name).second) << effect.name;
    EXPECT_FALSE(effect.phrase.empty()) << effect.name;
    EXPECT_NE(effect.apply, nullptr) << effect.name;
    EXPECT_STRNE(get_family_name(effect.family), "") << effect.name;
    EXPECT_EQ(find_effect(effect.name), &get_effect(effect.id)) << effect.name;
  }
}

// A load ratio of 2 could be found, and only 1 simulated.
TEST(EffectTable, NothingIsFoundThatCannotBeSimulated) {
  for (const EffectInfo& effect : list_effects()) {
    for (const EffectParameter& p : effect.parameters) {
      EXPECT_LE(p.lower, p.low) << effect.name << '.' << p.key();
      EXPECT_LE(p.low, p.high) << effect.name << '.' << p.key();
      EXPECT_LE(p.high, p.upper) << effect.name << '.' << p.key();
    }
  }
}

TEST(EffectTable, AddsAStribeckCurveToTheFrictionThatIsThere) {
  JointLaws laws;
  laws.coulomb = 1.0;
  laws = apply_to(laws, EffectId::kStribeck, {2.0, 3.0, 0.1, 0.0});
  EXPECT_DOUBLE_EQ(calc_static_level(laws, 0.0, 1.0), 4.0);
  EXPECT_NEAR(calc_friction_level(laws, 10.0, 0.0, 1.0), 3.0, 1e-12);
  laws = apply_to(laws, EffectId::kCoulomb, {0.5, 0.0});
  EXPECT_DOUBLE_EQ(calc_static_level(laws, 0.0, 1.0), 4.5) << "whatever the order";
}

// 617 rad/s is what a fit made of a constant limit of 19 N m at joint speeds of 3 rad/s.
TEST(EffectTable, ADriveWhoseTorqueHardlyFallsUpToItsLargestSpeedHasAConstantLimit) {
  const EffectInfo& info = *find_effect("velocity_limit");
  const double values[] = {19.0, 617.0};  // stall torque [N m], speed without torque [rad/s]
  const SpecialCase constant = info.find_special_case(values, 3.0, 0.0);
  EXPECT_EQ(constant.id, EffectId::kSaturation);
  EXPECT_EQ(constant.p, std::vector<double>{19.0});
  EXPECT_TRUE(info.find_special_case(values, 100.0, 0.0).p.empty()) << "a sixth of the torque is gone at that speed";
}

TEST(EffectTable, CombinesTwoSpringsAtOneJoint) {
  JointLaws laws = apply_to(JointLaws{}, EffectId::kSpring, {30.0, 0.0});
  laws = apply_to(laws, EffectId::kSpring, {10.0, 0.4});
  EXPECT_DOUBLE_EQ(laws.spring_stiffness, 40.0);
  EXPECT_DOUBLE_EQ(laws.spring_rest, 0.1);
}

// What is found beside what is stated must leave the stated part as it is, or it would be written back twice.
TEST(EffectTable, AnAbsentEffectLeavesWhatWasStatedAtTheSameJoint) {
  const JointLaws stated = apply_to(apply_to(JointLaws{}, EffectId::kTorqueConstant, {0.8}), EffectId::kLag, {0.004});
  JointLaws laws = apply_to(stated, EffectId::kTorqueConstant, {1.0});
  laws = apply_to(apply_to(laws, EffectId::kLag, {0.0}), EffectId::kDelay, {0.0});
  laws = apply_to(apply_to(laws, EffectId::kJointOffset, {0.0}), EffectId::kRotorInertia, {0.0});
  EXPECT_DOUBLE_EQ(laws.torque_scale, 0.8);
  EXPECT_DOUBLE_EQ(laws.lag, 0.004);
}

TEST(EffectTable, RefusesValuesByParameterAndBound) {
  std::vector<double> values;
  const ValueFault fault = find_values(get_effect(EffectId::kLoadFriction), {{"ratio", 2.0}}, &values);
  EXPECT_EQ(fault.parameter, "ratio");
  EXPECT_EQ(fault.message, "is 2, expected 0 to 1 1");
}

// Columns are derivatives of the missing torque over the coefficients, so the coefficients that make a row's parameters
// give them back.
TEST(EffectTable, GivesParametersFromTheCoefficientsOfItsTorqueColumns) {
  for (const EffectInfo& effect : list_effects()) {
    const TorqueRegressor& torque = effect.torque;
    if (torque.num_columns == 0) continue;
    const std::vector<double> shape =
        torque.shapes.empty() ? std::vector<double>{20.0} : torque.shapes[0];  // periods [1/rad]
    std::vector<double> x(static_cast<size_t>(torque.num_columns), 0.5), p(effect.parameters.size(), -1.0), c(x.size());
    const JointSample sample{0.3, 0.2, 1.0, 1.0, 4.0, 2.0};
    torque.calc_columns(sample, shape.data(), c.data());
    for (double column : c) EXPECT_TRUE(std::isfinite(column)) << effect.name;
    EXPECT_TRUE(torque.make_parameters(x.data(), shape.data(), p.data())) << effect.name;
    for (size_t i = 0; i < p.size(); ++i) {
      EXPECT_GE(p[i], effect.parameters[i].low) << effect.name << '.' << effect.parameters[i].key();
      EXPECT_LE(p[i], effect.parameters[i].high) << effect.name << '.' << effect.parameters[i].key();
    }
  }
}

// Turned by +0.1 rad about x, the base's y axis points up: what falls, falls towards -y.
TEST(EffectTable, ABaseThatRollsToTheRightFeelsGravityOnItsRight) {
  Vector3d gravity(0.0, 0.0, -9.81);
  EffectTarget target;
  target.gravity_W = &gravity;
  const double values[] = {0.1, 0.0};
  find_effect("base_tilt")->apply(values, target);
  EXPECT_NEAR(gravity.y(), -9.81 * std::sin(0.1), 1e-12);  // rounding
  EXPECT_NEAR(gravity.z(), -9.81 * std::cos(0.1), 1e-12);
}

TEST(EffectTable, OfAnArmThatIsCarriedByThreeQuartersAQuarterOfItsWeightIsLeft) {
  Vector3d gravity(0.0, 0.0, -8.0);
  EffectTarget target;
  target.gravity_W = &gravity;
  const double values[] = {0.75};
  find_effect("gravity_compensation")->apply(values, target);
  EXPECT_DOUBLE_EQ(gravity.z(), -2.0);
}

TEST(EffectTable, AConstantTorqueIsTakenFromWhatTheDriveWasAskedForAtAnySpeed) {
  JointLaws laws;
  EffectTarget target;
  target.joint = &laws;
  const double values[] = {0.5};
  find_effect("constant_torque")->apply(values, target);
  for (double v : {-2.0, 0.0, 3.0}) EXPECT_DOUBLE_EQ(calc_given_torque(laws, 2.0, v), 1.5);
}

}  // namespace
}  // namespace hrp
