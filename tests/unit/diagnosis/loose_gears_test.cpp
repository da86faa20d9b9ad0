// SPDX-License-Identifier: BSD-3-Clause
// Play and give of a gear beside friction, by the simulation of the joint.
#include <gtest/gtest.h>

#include "diagnosis/evidence/best_model.h"
#include "diagnosis/evidence/loose_gears.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

// With less at the elbow: what is loose there shows.
Hypothesis make_rigid_drives() {
  Hypothesis drives = make_arm_drives();
  drives[4] = {EffectId::kCoulomb, kElbow, {0.3, 0.0, 5e-4}};
  drives[5] = {EffectId::kRotorInertia, kElbow, {0.05}};
  return drives;
}

// Turned over: gravity does not hold the teeth on one side.
std::string make_flat_arm() {
  std::string urdf = kArm;
  for (size_t at; (at = urdf.find("xyz=\"0 1 0\"")) != std::string::npos;) urdf.replace(at, 11, "xyz=\"0 0 1\"");
  return urdf;
}

// Play of 20 mrad beside a Stribeck curve that the rigid model has no need of, and a mass that stands for a part of it.
TEST(LooseGearsNightly, PlayIsToldBesideFrictionAndAMassThatWereFittedWithoutIt) {
  Hypothesis truth = make_rigid_drives();
  truth[4] = {EffectId::kStribeck, kElbow, {0.3, 0.5, 0.08, 0.0, 3e-6}};
  truth.back() = {EffectId::kBacklash, kElbow, {0.02, 400.0, 0.15, 0.05}};
  const Experiment e = make_simulated_experiment("loose_beside", make_flat_arm(), {"shoulder", "elbow"}, truth);
  Hypothesis model = make_rigid_drives();
  model.push_back({EffectId::kMassError, at_link(kFore), {1.06}});
  const std::vector<LooseGear> found = find_all_loose_gears(make_problem(e, 2), &model);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].law().id, EffectId::kBacklash);
  EXPECT_NEAR(found[0].law().p[0], 0.02, 0.002);  // a tenth: the mass is still there
  EXPECT_TRUE(found[0].named);
}

// The model has the right drives, but for what is hidden at the elbow in the place of its rigid rotor, or beside it.
std::vector<LooseGear> find_with(const char* name, const Effect& hidden, bool beside = false) {
  Hypothesis truth = make_rigid_drives();
  if (beside)
    truth.push_back(hidden);
  else
    truth.back() = hidden;
  const Experiment e = make_simulated_experiment(name, make_flat_arm(), {"shoulder", "elbow"}, truth);
  Hypothesis model = make_rigid_drives();
  return find_all_loose_gears(make_problem(e, 2), &model);
}

TEST(LooseGearsNightly, PlayOfTenMilliradiansIsToldWithItsGap) {
  const std::vector<LooseGear> found =
      find_with("loose_play", {EffectId::kBacklash, kElbow, {0.01, 3000.0, 3.0, 0.05}});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].law().id, EffectId::kBacklash);
  EXPECT_EQ(found[0].law().place, at_joint(kElbow));
  EXPECT_NEAR(found[0].law().p[0], 0.01, 1.96 * found[0].std[0] + 2e-4);  // a sample of the encoder's rounding beside
  EXPECT_LT(found[0].std[0], 0.002);
  EXPECT_LT(found[0].left, 0.3);
  EXPECT_TRUE(found[0].named);
}

TEST(LooseGears, AShaftThatGivesIsToldWithItsStiffness) {
  const std::vector<LooseGear> found = find_with("loose_give", {EffectId::kElasticity, kElbow, {150.0, 0.3, 0.05}});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].law().id, EffectId::kElasticity);  // the simplest: play of no width is elastic, too
  EXPECT_NEAR(found[0].law().p[0], 150.0, 15.0);        // a tenth: what friction at either side of the shaft takes
}

TEST(LooseGears, NoGearIsLooseWhereAnotherLawIsMissing) {
  EXPECT_TRUE(find_with("loose_texture", {EffectId::kCogging, kElbow, {0.3, 9.0, 0.5}}, true).empty());
  EXPECT_TRUE(find_with("loose_load", {EffectId::kLoadFriction, kElbow, {0.3, 5e-4}}, true).empty());
  EXPECT_TRUE(find_with("loose_delay", {EffectId::kDelay, kElbow, {0.012}}, true).empty());
  EXPECT_TRUE(
      find_with("loose_payload", {EffectId::kPayload, at_link(kFore), {0.3, 0.25, 0.0, 0.0, 0.0, 0.0, 0.0}}, true)
          .empty());
}

// 2 sqrt(600 * 0.16) is 19.6 N m s/rad.
TEST(LooseGears, ASpringThatOnlyCreepsIsNoElasticGear) {
  EXPECT_TRUE(is_gear({EffectId::kElasticity, kElbow, {600.0, 3.0, 0.16}}));
  EXPECT_TRUE(is_gear({EffectId::kElasticity, kElbow, {600.0, 19.0, 0.16}}));
  EXPECT_FALSE(is_gear({EffectId::kElasticity, kElbow, {600.0, 20.0, 0.16}}));
}

TEST(LooseGears, NoGearIsLooseInARobotOfRigidGears) {
  EXPECT_TRUE(find_with("loose_nothing", make_rigid_drives().back()).empty());
}

// What was fitted with a rigid gear has made up for its play: here the shoulder's rotor and friction are off. The gap
// lies between the usual starts of a fit, 10 and 30 mrad: the play was not found there, and the shoulder got one in its
// place.
TEST(LooseGears, TheWholeRobotIsFittedAgainBesideThem) {
  Hypothesis truth = make_rigid_drives();
  truth.back() = {EffectId::kBacklash, kElbow, {0.02, 3000.0, 3.0, 0.05}};
  const Experiment e = make_simulated_experiment("loose_whole", make_flat_arm(), {"shoulder", "elbow"}, truth);
  Hypothesis off = make_rigid_drives();
  off[0].p[0] = 0.5;
  off[2].p[0] = 0.75;
  const Problem problem = make_problem(e, 2);
  Trial model = simulate_trial(problem, off);
  const std::vector<Finding> findings = loosen_gears(problem, problem, &model, [](const std::string&) {});
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].effect, "backlash");
  EXPECT_EQ(findings[0].where.at("joint"), "elbow");
  const Estimate& gap = findings[0].parameters[0];
  EXPECT_NEAR(gap.value[0], 0.02, 1.96 * gap.std[0] + 2e-4);  // a sample of the encoder's rounding beside
  // Twice the noise: the threshold above which a joint is fitted once more.
  EXPECT_LT(model.rms, 2.0);
  for (const Effect& effect : model.hypothesis) {
    if (effect.place != at_joint(kShoulder)) continue;
    // A percent: what the nonsmooth law leaves.
    if (effect.id == EffectId::kViscous) {
      EXPECT_NEAR(effect.p[0], 0.8, 0.008);
    } else if (effect.id == EffectId::kRotorInertia) {
      EXPECT_NEAR(effect.p[0], 0.6, 0.006);
    }
  }
}

}  // namespace
}  // namespace hrp::diagnosis
