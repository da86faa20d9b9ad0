// SPDX-License-Identifier: BSD-3-Clause
// What the wide search along the recorded paths proposes.
#include <gtest/gtest.h>

#include "diagnosis/search/explore.h"
#include "diagnosis/search/nearby.h"
#include "diagnosis/search/search.h"
#include "diagnosis/search/trials.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

// The best set of one effect that is proposed for play: it is that play, and what it leaves of the squares there were.
struct Proposal {
  Effect effect;
  double left = 1.0;
};

Proposal find_play(const std::string& name, const Effect& hidden) {
  const Experiment e = simulate_arm(name, {hidden});
  Problem problem = make_problem(e, 1);
  prepare_paths(&problem);
  Explorer explorer(problem);
  const std::vector<Lead> leads = explorer.grow({explorer.nominal()}, 10, {0, 0});
  EXPECT_EQ(leads.at(0).hypothesis.size(), 1u);
  Proposal best{leads.at(0).hypothesis.at(0), leads.at(0).cost / explorer.nominal().cost};
  EXPECT_EQ(best.effect.id, EffectId::kBacklash);
  EXPECT_EQ(best.effect.place, hidden.place);
  return best;
}

// A heavy rotor behind play changes the motion so much that a regression on what a small gap does finds no gap at all.
TEST(DiagnosisExplore, PlayBehindAHeavyRotorIsProposed) {
  const Proposal best = find_play("explore_play", {EffectId::kBacklash, kShoulder, {0.03, 2e4, 8.0, 0.4}});
  EXPECT_NEAR(best.effect.p[0], 0.03, 0.003);  // a lead, not a fit: other joints' motion is as recorded
  EXPECT_LT(best.left, 0.02);
}

// On a small joint a rotor of some 1e-3 kg m^2 rattles at gear stiffnesses far below 1e3 N m/rad.
TEST(DiagnosisExploreNightly, PlayOfASmallJointIsProposed) {
  const Proposal best = find_play("explore_small", {EffectId::kBacklash, kElbow, {0.02, 300.0, 0.12, 0.004}});
  EXPECT_LT(best.left, 0.2);  // the shoulder, as recorded, feels the play of the elbow, too
}

// Every rattle comes at another time: a gap that is a third off lies behind many minima.
TEST(DiagnosisExplore, AGapIsFoundFromAThirdOff) {
  const Effect hidden{EffectId::kBacklash, kShoulder, {0.03, 2e4, 8.0, 0.4}};
  const Experiment e = simulate_arm("nearby_gap", {hidden});
  const Problem problem = make_problem(e, 1);
  Effect start = hidden;
  start.p[0] *= 0.67;
  const Hypothesis found = try_nearby(problem, {start});
  EXPECT_NEAR(found[0].p[0], 0.03, 0.03 * (kFinestFactor - 1.0));  // the last step of the walk
}

// Of play in a joint where a rotor was fitted that leaves much, the gaps and stiffnesses are scanned.
TEST(DiagnosisExplore, PlayIsFoundFromARotorThatLeavesMuch) {
  const Effect hidden{EffectId::kBacklash, kShoulder, {0.01, 4e4, 16.0, 0.4}};
  const Experiment e = simulate_arm("loosen_play", {hidden});
  Trials trials(make_problem(e, 1), [](const std::string&) {});
  trials.add({{EffectId::kRotorInertia, kShoulder, {0.2}}});
  const Trial rotor = trials.best();
  ASSERT_EQ(rotor.hypothesis.size(), 1u);
  EXPECT_GT(rotor.rms, 2.0);  // not noise
  const std::vector<Effect> options = list_options(list_transmissions(kShoulder, rotor.hypothesis[0].p[0])[1], false);
  const Trial play = trials.fit_aside({trials.choose(rotor, 0, options, 1).at(0)});
  EXPECT_LT(play.rms, 1.2);  // noise, by the bar of a name
  EXPECT_NEAR(play.hypothesis.at(0).p[0], 0.01, 0.0005);
}

// The servo of a drive behind a shaft that gives may read its encoder and take its commands at other moments than the
// others; 80 us at 1 rad/s are four deviations of the encoder's noise.
TEST(DiagnosisExplore, ADriveBehindAShaftThatGivesHasItsOwnTiming) {
  const Effect shaft{EffectId::kElasticity, kElbow, {600.0, 1.0, 0.05}};
  const Experiment e = simulate_arm("own_timing", {shaft, {EffectId::kDriveTiming, kElbow, {8e-5}}});
  Trials trials(make_problem(e, 1), [](const std::string&) {});
  const Trial fitted = trials.fit_aside({shaft});
  EXPECT_LT(fitted.rms, 1.1);
  ASSERT_EQ(fitted.hypothesis.size(), 1u);
  ASSERT_EQ(fitted.timing.size(), 2u);
  EXPECT_EQ(fitted.timing[1].id, EffectId::kDriveTiming);
  EXPECT_NEAR(fitted.timing[1].p[0], 8e-5, 1e-5);  // 12 s of one arm
}

TEST(DiagnosisExplore, ASearchWithoutWorkLeftSaysSoAndNamesNothing) {
  const Experiment e = simulate_arm("explore_spent", {{EffectId::kBacklash, kShoulder, {0.03, 2e4, 8.0, 0.4}}});
  Problem problem = make_problem(e, 1);
  problem.most_work = 1.0;
  const Outcome outcome = search(problem, [](const std::string&) {});
  EXPECT_TRUE(outcome.spent);
  EXPECT_FALSE(outcome.explained);
}

Trial make_trial(const Hypothesis& hypothesis, double train, double held) {
  Trial trial;
  trial.hypothesis = hypothesis;
  trial.train.ok = true;
  trial.train.count = 1e4;
  trial.train.chi2 = train * train * trial.train.count;
  trial.rms = held;
  trial.worst = 1.5 * held;
  return trial;
}

TEST(DiagnosisTrial, SeveralSmoothEffectsMustPredictAsWellAsTheyFit) {
  const Effect scale{EffectId::kTorqueConstant, kElbow, {1.2}}, mass{EffectId::kMassError, kFore, {1.1}};
  const Effect dry{EffectId::kCoulomb, kElbow, {0.5, 0.0, 1e-3}};
  const Trial nominal = make_trial({}, 100.0, 100.0);
  EXPECT_TRUE(is_explained(make_trial({scale, mass}, 1.3, 1.35), nominal));
  EXPECT_FALSE(is_explained(make_trial({scale, mass}, 1.03, 1.35), nominal));
  // One alone cannot bend, and friction sticks at other places in other recordings.
  EXPECT_TRUE(is_explained(make_trial({scale}, 1.03, 1.35), nominal));
  EXPECT_TRUE(is_explained(make_trial({scale, dry}, 1.03, 1.35), nominal));
}

// A thousandth of the mismatch may be the detail of a law that two engines write differently. Where it is more than
// passes for noise something small may hide in it, such as an encoder's zero beside a load and hysteresis.
TEST(DiagnosisTrial, FrictionThatLeavesMoreThanNoiseIsAskedForMore) {
  const Effect hysteresis{EffectId::kHysteresis, kShoulder, {2.0, 0.05}};
  const Trial nominal = make_trial({}, 80.0, 80.0);
  Trial left = make_trial({hysteresis}, 1.5, 1.55);
  left.worst = 3.0;
  EXPECT_TRUE(is_explained(left, nominal));
  EXPECT_FALSE(is_complete(left, nominal));
  left.rms = 1.1;
  EXPECT_TRUE(is_complete(left, nominal));
}

// A hundred thousand readings that a rotor leaves 2 % above the noise are no chance and no detail of a law.
TEST(DiagnosisTrial, ARotorGivesWayToATransmissionThatTheFitIsSureOf) {
  const Effect rotor{EffectId::kRotorInertia, kShoulder, {0.4}};
  const Effect elastic{EffectId::kElasticity, kShoulder, {3e4, 60.0, 0.4}};
  const Trial nominal = make_trial({}, 40.0, 40.0);
  Trial stiff = make_trial({rotor}, 1.02, 1.002), gives = make_trial({elastic}, 1.0, 1.001);
  for (Trial* t : {&stiff, &gives}) {
    t->train.count *= 10.0;
    t->train.chi2 *= 10.0;
  }
  std::vector<Trial> list{gives, stiff};
  sort_by_preference(nominal, &list);
  EXPECT_EQ(list[0].hypothesis[0].id, EffectId::kElasticity);
  // Where both leave the same, the simpler one.
  stiff = make_trial({rotor}, 1.0005, 1.001);
  list = {gives, stiff};
  sort_by_preference(nominal, &list);
  EXPECT_EQ(list[0].hypothesis[0].id, EffectId::kRotorInertia);
}

}  // namespace
}  // namespace hrp::diagnosis
