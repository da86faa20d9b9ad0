// SPDX-License-Identifier: BSD-3-Clause
// A whole round: what the recordings of the proposed motions tell a search.
#include <gtest/gtest.h>

#include "diagnosis/estimate/significance.h"
#include "diagnosis/next/propose.h"
#include "diagnosis/next/trial_motion.h"
#include "diagnosis/report/report.h"
#include "diagnosis/search/fit.h"
#include "tests/test_places.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

const Progress kQuietly = [](const std::string&) {};
constexpr int kUpperArm = 1;  // link

Hypothesis make_heavy() { return {{EffectId::kMassError, at_link(kUpperArm), {1.1}}}; }

// The shoulder stood still: its drive gives more than the model says.
Json make_open_report() {
  Json finding{
      {"effect", "mass_error"}, {"where", {{"link", "upper_arm"}}}, {"parameters", {{"scale", {{"value", 1.1}}}}}};
  finding["alternatives"] = {{{"effect", "torque_constant_error"},
                              {"where", {{"joint", "shoulder"}}},
                              {"parameters", {{"scale", {{"value", 0.93}}}}}}};
  return {{"verdict", "explained"}, {"findings", {finding}}};
}

// The shipped arm, its recordings and one round of motions of 6 s, played by an arm whose upper link is heavier.
Experiment play_round() {
  Experiment e = load_experiment(source_dir() + "/models/experiments/lifter/experiment.yaml");
  NextOptions options;
  options.seconds = 6.0;
  options.jobs = 2;
  const Next next = propose(e, make_open_report(), options, kQuietly);
  Experiment bare = e;
  bare.recordings.clear();
  const Recording like = e.recordings[0];
  TestNoise noise;
  for (const Proposal& p : next.proposals) {
    Recording played = make_trial_motion(bare, like, p.commands, make_heavy())->experiment.recordings[0];
    for (size_t j = 0; j < played.joints.size(); ++j) {
      for (size_t q = 0; q < kQuantities; ++q) {
        for (double& x : played.joints[j].signal[q]) x += e.joint_noise[j][q].sigma * noise.draw();
      }
    }
    played.spec.name = p.file;
    played.spec.train = e.recordings.size() % 2 == 0;
    e.recordings.push_back(played);
  }
  return e;
}

// Along recorded paths, a torque constant, a load and a mass fit nearly alike; only the simulation tells them apart.
TEST(NextRound, AHeavyLinkIsToldFromATorqueConstantAndKnownBetterThanBefore) {
  const Experiment before = load_experiment(source_dir() + "/models/experiments/lifter/experiment.yaml");
  const Experiment after = play_round();
  ASSERT_EQ(after.recordings.size(), 4u);
  const Problem problem = make_problem(after, 2);
  const Outcome outcome = search(problem, kQuietly);
  ASSERT_EQ(outcome.chosen.hypothesis.size(), 1u);
  EXPECT_EQ(outcome.chosen.hypothesis[0].id, EffectId::kMassError);
  EXPECT_EQ(outcome.chosen.hypothesis[0].place.index, kUpperArm);
  EXPECT_NEAR(outcome.chosen.hypothesis[0].p[0], 1.1,
              2.0 * kNinetyFive * outcome.chosen.std[0][0]);  // of a fixed draw of the noise
  const Problem first = make_problem(before, 2);
  FitOptions options;
  options.intervals = true;
  EXPECT_LT(outcome.chosen.std[0][0], fit(first, make_heavy(), first.train, options).std[0][0]);
  // The torque constant leaves 4 % more than the mass: that is the nearest one, not what leaves a third more.
  const std::string statement = make_reports(problem, outcome).report["findings"][0]["statement"];
  EXPECT_NE(statement.find("@shoulder, leaves 1.0"), std::string::npos) << statement;
}

}  // namespace
}  // namespace hrp::diagnosis
