// SPDX-License-Identifier: BSD-3-Clause
// Walks among the motions of the next experiment.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/next/limits.h"
#include "diagnosis/next/propose.h"
#include "diagnosis/next/stance_motions.h"
#include "diagnosis/next/stance_trial.h"
#include "diagnosis/next/walk_motions.h"
#include "diagnosis/report/report.h"
#include "tests/test_places.h"

namespace hrp::diagnosis {
namespace {

const std::string kFile = source_dir() + "/models/experiments/standing/experiment.yaml";

Commands make_walk_of(const Experiment& e, const Limits& limits, unsigned seed, double seconds) {
  MotionPlan plan;
  plan.family = Family::kWalk;
  plan.seed = seed;
  plan.seconds = seconds;
  plan.moves.assign(limits.joints.size(), 1);
  return make_stance_motion(e, plan, limits);
}

// Two gaits: long slow steps and short quick ones.
TEST(NextWalk, AWalkKeepsTheRobotOnTheSolesThatCarryIt) {
  const Experiment e = load_experiment(kFile);
  const Limits limits = make_limits(e, {});
  for (unsigned seed : {1u, 2u}) {
    const Commands walk = make_walk_of(e, limits, seed, 10.0);
    ASSERT_FALSE(walk.time.empty()) << seed;
    EXPECT_LE(walk.time.back(), 10.0);
    const StanceRun run = run_stance(e, e.scenario, walk, limits, true);
    EXPECT_EQ(run.fault, "") << seed;
    EXPECT_GE(run.margin, kZmpMargin) << seed;
    EXPECT_EQ(run_stance(e, e.scenario, walk, limits).fault, "a foot comes off the ground") << seed;  // it does walk
  }
}

TEST(NextWalk, AWalkBeginsAndEndsInTheStartPose) {
  const Experiment e = load_experiment(kFile);
  const Limits limits = make_limits(e, {});
  const Commands walk = make_walk_of(e, limits, 1, 10.0);
  ASSERT_FALSE(walk.time.empty());
  for (size_t j = 0; j < walk.position.size(); ++j) {
    EXPECT_NEAR(walk.position[j].front(), limits.joints[j].start, 1e-6);
    EXPECT_NEAR(walk.position[j].back(), limits.joints[j].start, 1e-4);  // the last sample is up to 4 ms before the end
  }
}

// Settling and two shifts of weight alone take 5 s.
TEST(NextWalk, NoWalkIsMadeForATimeThatIsTooShortForSteps) {
  const Experiment e = load_experiment(kFile);
  EXPECT_TRUE(make_walk_of(e, make_limits(e, {}), 1, 5.0).time.empty());
}

// Half of the robot's mass, half a metre before it: it falls over its toes.
TEST(NextWalk, AWalkThatTipsTheRobotIsAFault) {
  const Experiment e = load_experiment(kFile);
  const Limits limits = make_limits(e, {});
  const Commands walk = make_walk_of(e, limits, 1, 10.0);
  ASSERT_FALSE(walk.time.empty());
  const nlohmann::json load = {{"effect", "payload"},
                               {"where", {{"link", "trunk"}}},
                               {"parameters", {{"mass", 18.0}, {"com", {0.5, 0.0, 0.2}}}}};
  const Scenario loaded = parse_scenario(make_scenario_text(e, nlohmann::json::array({load})), e.scenario.path);
  EXPECT_NE(run_stance(e, loaded, walk, limits, true).fault, "");
}

// The sensor of the left foot reads a hundredth for a while.
Experiment lift_left_foot(Experiment e) {
  for (Recording& r : e.recordings) {
    for (auto& [name, column] : r.other) {
      for (size_t k = r.size() / 3; k < r.size() / 2 && name.rfind("/wrench/left_foot_ft/", 0) == 0; ++k)
        column[k] *= 0.01;
    }
  }
  return e;
}

TEST(NextWalk, ARobotWalksIfAFootLeavesTheGroundAndComesBack) {
  const Experiment e = load_experiment(kFile);
  EXPECT_FALSE(is_walking(e));
  EXPECT_TRUE(is_walking(lift_left_foot(e)));
}

int count_tried(const Experiment& e, const char* verdict) {
  NextOptions options;
  options.seconds = 4.0;
  options.count = 1;
  const Json friction{{"effect", "viscous_friction"},
                      {"where", {{"joint", "left_knee"}}},
                      {"parameters", {{"coefficient", {{"value", 3.0}}}}}};
  return propose(e, {{"verdict", verdict}, {"findings", Json::array({friction})}}, options, [](const std::string&) {})
      .tried;
}

Json make_foot_load(const char* foot) {
  return {{"effect", "payload"},
          {"where", {{"link", foot}}},
          {"parameters", {{"mass", {{"value", 0.05}}}, {"com", {{"value", {0.0, 0.0, 0.0}}}}}}};
}

// A joint that stood still would be asked to move first, whatever else is open.
Experiment move_all(Experiment e) {
  for (Recording& r : e.recordings) {
    for (JointColumns& joint : r.joints) {
      for (size_t k = 0; k < r.size(); ++k) joint.command[k] += 0.2 * std::sin(r.time[k]);
    }
  }
  return e;
}

// Fifty grams. The ground carries them, below the sensor, while the foot stands; legs that swing carry them.
TEST(NextWalk, WhichFootCarriesALoadIsAskedByAWalk) {
  const Experiment e = move_all(lift_left_foot(load_experiment(kFile)));
  NextOptions options;
  options.seconds = 10.0;
  options.count = 1;
  options.jobs = 2;
  Json finding = make_foot_load("left_sole_link");
  finding["alternatives"] = Json::array({make_foot_load("right_sole_link")});
  const Next next =
      propose(e, {{"verdict", "explained"}, {"findings", Json::array({finding})}}, options, [](const std::string&) {});
  ASSERT_EQ(next.proposals.size(), 1u) << next.nothing;
  const Proposal& p = next.proposals[0];
  EXPECT_EQ(p.plan.family, Family::kWalk) << get_family_word(p.plan.family);
  EXPECT_GT(p.expected[0].probability, 0.9);
  const Scenario loaded = parse_scenario(
      make_scenario_text(e, nlohmann::json::array({nlohmann::json::parse(finding.dump())})), e.scenario.path);
  EXPECT_EQ(run_stance(e, loaded, p.commands, make_limits(e, {}), true).fault, "");
}

// Nothing corrects a walk that is played: what the report cannot explain may make the robot fall. Two gaits.
TEST(NextWalk, OnlyARobotThatIsExplainedAndWasSeenToWalkIsAskedToWalk) {
  const Experiment stood = move_all(load_experiment(kFile)), walked = lift_left_foot(stood);
  const int without = count_tried(stood, "explained");
  EXPECT_EQ(count_tried(walked, "explained"), without + 2);
  EXPECT_EQ(count_tried(walked, "partly_explained"), count_tried(stood, "partly_explained"));
}

}  // namespace
}  // namespace hrp::diagnosis
