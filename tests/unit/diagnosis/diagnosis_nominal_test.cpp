// SPDX-License-Identifier: BSD-3-Clause
// What an experiment states about its robot is in every engine's nominal model: it is not found again and added twice.
#include "diagnosis/model/nominal.h"
#include "diagnosis/standing/terms.h"
#include "simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

const StatedEffect kStatedFriction{"coulomb_friction", {{"level", 2.0}, {"asymmetry", 0.1}}};
const StatedEffect kStatedPayload{"payload", {{"mass", 0.5}, {"com_x", 0.3}, {"com_y", 0.0}, {"com_z", 0.0}}};

Experiment make_stating() {
  const Hypothesis hidden{{EffectId::kCoulomb, kElbow, {2.0, 0.1, kPresliding}},
                          {EffectId::kPayload, kFore, {0.5, 0.3, 0.0, 0.0, 0.0}}};
  Experiment e = simulate_arm("nominal", hidden);
  e.scenario.joint_laws["elbow"] = {kStatedFriction};
  e.scenario.link_laws["fore"] = {kStatedPayload};
  return e;
}

TEST(NominalModel, OfAFixedBaseHasWhatTheExperimentStates) {
  const Experiment e = make_stating();
  const Problem problem = make_problem(e, 1);
  // 1 is the noise; a friction of 2 N m or a payload of 0.5 kg on its own is tens of times that.
  EXPECT_LT(calc_score(problem, {}, problem.train).rms(), 1.5);
}

TEST(NominalModel, OfAFixedBaseTakesNoFrictionTwice) {
  const Plant plant = make_plant(make_stating(), {{EffectId::kCoulomb, kElbow, {0.0, 0.0, kPresliding}}});
  EXPECT_DOUBLE_EQ(plant.laws[kElbow].coulomb, 2.0);
  EXPECT_DOUBLE_EQ(plant.tree.links[kFore].inertia.mass, 1.5);
}

TEST(NominalModel, OfAStandingRobotHasWhatTheExperimentStates) {
  const NominalRobot nominal = make_nominal(make_stating());
  standing::StandProblem problem;
  problem.tree = nominal.tree;
  problem.laws = nominal.laws;
  const standing::Terms terms(problem, {{EffectId::kCoulomb, at_joint(kElbow), {0.5, 0.0}}});
  EXPECT_DOUBLE_EQ(terms.joints[kElbow].laws.coulomb, 2.5);
  EXPECT_DOUBLE_EQ(terms.joints[kElbow].laws.asymmetry, 0.1);
  EXPECT_DOUBLE_EQ(terms.tree.links[kFore].inertia.mass, 1.5);
}

// A payload had an inertia in three engines of four.
TEST(NominalModel, OfAStandingRobotGivesAPayloadTheInertiaThatTheSimulatorGivesIt) {
  const Experiment e = make_stating();
  standing::StandProblem problem;
  problem.tree = e.robot.tree;
  const standing::Terms terms(problem,
                              {{EffectId::kPayload, at_link(kFore), {0.5, 0.15, 0.0, 0.0}}});  // mass, mass x com
  const LinkInertia found = terms.tree.links[kFore].inertia, stated = make_nominal(e).tree.links[kFore].inertia;
  EXPECT_NEAR((found.I_LLcm_L - stated.I_LLcm_L).norm(), 0.0, 1e-12);
  EXPECT_NEAR((found.p_LLcm_L - stated.p_LLcm_L).norm(), 0.0, 1e-12);
}

TEST(NominalModel, AFloatingRobotsRecordingIsNotSmoothedForAFixedBase) {
  Experiment e = make_stating();
  e.scenario.floating_base = true;
  EXPECT_TRUE(make_problem(e, 1).smooth[0].joints.empty());
}

TEST(Score, OfARolloutThatDidNotEndEverySignalIsFarOff) {
  EXPECT_DOUBLE_EQ(Score().rms(2), 1e300) << "a report lists the signals of a model that diverged, too";
}

}  // namespace
}  // namespace hrp::diagnosis
