// SPDX-License-Identifier: BSD-3-Clause
// The next experiment of a robot on its feet: what is proposed keeps it there, whichever explanation holds.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "diagnosis/next/limits.h"
#include "diagnosis/next/propose.h"
#include "diagnosis/next/stance_motions.h"
#include "diagnosis/next/stance_trial.h"
#include "diagnosis/next/stance_worlds.h"
#include "diagnosis/report/report.h"
#include "test_places.h"

namespace hrp::diagnosis {
namespace {

const std::string kFolder = std::string(HRP_SOURCE_DIR) + "/models/experiments/";
const Progress kQuietly = [](const std::string&) {};

Json make_sole(const std::string& foot, double stiffness) {
  Json parameters;
  for (const auto& [name, value] : {std::pair{"kz", 2e5}, {"cz", 1000.0}, {"k_roll", 0.7 * stiffness}, {"c_roll", 4.0}, {"k_pitch", stiffness}, {"c_pitch", 5.0}})
    parameters[name] = {{"value", value}};
  return {{"effect", "foot_compliance"}, {"where", {{"foot", foot}}}, {"parameters", parameters}};
}

// `forward` [m] of the trunk.
Json make_load(double mass, double forward) {
  return {{"effect", "payload"}, {"where", {{"link", "trunk"}}}, {"parameters", {{"mass", mass}, {"com", {forward, 0.0, 0.1}}}}};
}

// "The left sole gives, or there is a load on the trunk"; the right one gives as well.
Json make_open_report(const Json& load) {
  Json left = make_sole("left_sole_link", 420.0), right = make_sole("right_sole_link", 390.0);
  left["alternatives"] = Json::array({load});
  return {{"verdict", "partly_explained"}, {"findings", {left, right}}};
}

NextOptions make_options() {
  NextOptions options;
  options.seconds = 4.0, options.count = 1, options.jobs = 2;
  return options;
}

// What the experiment's recordings really hide; no explanation has these values.
Scenario make_truth(const Experiment& e) {
  std::ifstream file(kFolder + "answers/standing.json");
  nlohmann::json effects = nlohmann::json::array();
  for (nlohmann::json hidden : nlohmann::json::parse(file)["hidden"]) {
    const nlohmann::json foot = hidden["foot"];
    hidden.erase("effect"), hidden.erase("foot");
    effects.push_back({{"effect", "foot_compliance"}, {"where", {{"foot", foot}}}, {"parameters", hidden}});
  }
  return parse_scenario(make_scenario_text(e, effects), e.scenario.path);
}

TEST(NextStance, ASoleOrALoadGetsAMotionThatKeepsTheRobotOnItsFeet) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  const Next next = propose(e, make_open_report(make_load(1.0, 0.0)), make_options(), kQuietly);
  ASSERT_EQ(next.proposals.size(), 1u) << next.nothing << (next.rejected.empty() ? "" : next.rejected[0]);
  ASSERT_EQ(next.explanations.size(), 2u) << next.remarks.back();
  const Proposal& p = next.proposals[0];
  ASSERT_EQ(p.expected.size(), 1u);
  EXPECT_GT(p.expected[0].probability, 0.5);
  const StanceRun run = run_stance(e, make_truth(e), p.commands, make_limits(e, {}));
  EXPECT_EQ(run.fault, "");
  EXPECT_GE(run.margin, kZmpMargin);
  for (size_t j = 0; j < p.stop.size(); ++j) EXPECT_LT(run.leave[j], p.stop[j]);
}

TEST(NextStance, NothingIsProposedThatAnAlternativeWouldFallIn) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  const Next next = propose(e, make_open_report(make_load(20.0, 0.6)), make_options(), kQuietly);
  EXPECT_TRUE(next.proposals.empty());
  EXPECT_NE(next.nothing, "");
  EXPECT_FALSE(next.rejected.empty());
}

TEST(NextStance, TheBodyMovesAndTheSolesStay) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  const Limits limits = make_limits(e, {});
  for (int f = static_cast<int>(Family::kSway); f < static_cast<int>(Family::kEnd); ++f) {
    MotionPlan plan;
    plan.family = static_cast<Family>(f), plan.size = 0.5, plan.seconds = 4.0, plan.moves.assign(limits.joints.size(), 1);
    const Commands motion = make_stance_motion(e, plan, limits);
    ASSERT_FALSE(motion.time.empty()) << get_family_word(plan.family);
    double travel = 0.0;
    for (size_t j = 0; j < motion.position.size(); ++j) {
      EXPECT_NEAR(motion.position[j].front(), limits.joints[j].start, 1e-4);
      EXPECT_NEAR(motion.position[j].back(), limits.joints[j].start, 1e-4);
      const auto [low, high] = std::minmax_element(motion.position[j].begin(), motion.position[j].end());
      travel = std::max(travel, *high - *low);
    }
    EXPECT_GT(travel, 0.01) << get_family_word(plan.family);
    EXPECT_EQ(run_stance(e, make_truth(e), motion, limits).fault.find("foot"), std::string::npos);
  }
}

double calc_travel_of(const Experiment& e, const Commands& motion, const std::string& joint) {
  const std::vector<double>& q = motion.position[static_cast<size_t>(e.robot.tree.find_joint(joint))];
  const auto [low, high] = std::minmax_element(q.begin(), q.end());
  return *high - *low;
}

TEST(NextStance, ASwingMovesOnlyWhatCarriesNoFoot) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  const Limits limits = make_limits(e, {});
  MotionPlan plan;
  plan.family = Family::kSwing, plan.seconds = 4.0;
  EXPECT_TRUE(make_stance_motion(e, plan, limits).time.empty());  // nothing may move
  plan.moves.assign(limits.joints.size(), 1);
  const Commands motion = make_stance_motion(e, plan, limits);
  ASSERT_FALSE(motion.time.empty());
  EXPECT_GT(calc_travel_of(e, motion, "waist"), 0.2);
  EXPECT_LT(calc_travel_of(e, motion, "left_ankle_roll"), 1e-9);
}

// Such legs cannot follow a sway or a rise: many humanoids walk from this pose.
TEST(NextStance, ARobotWithNearlyStraightKneesBendsThemFirst) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  Limits limits = make_limits(e, {});
  for (const char* side : {"left_", "right_"}) {
    for (const auto& [joint, angle] : {std::pair{"hip_pitch", -0.04}, {"knee", 0.08}, {"ankle_pitch", -0.04}}) {
      JointLimits& one = limits.joints[static_cast<size_t>(e.robot.tree.find_joint(std::string(side) + joint))];
      one.start = angle;
      if (std::string(joint) == "knee") one.lower = angle;  // knees do not bend backwards
    }
  }
  for (Family family : {Family::kSway, Family::kSquat}) {
    MotionPlan plan;
    plan.family = family, plan.size = 0.5, plan.seconds = 6.0, plan.moves.assign(limits.joints.size(), 1);
    const Commands motion = make_stance_motion(e, plan, limits);
    ASSERT_FALSE(motion.time.empty()) << get_family_word(family);
    EXPECT_GT(calc_travel_of(e, motion, "left_knee"), 0.1);
    EXPECT_NEAR(motion.position[static_cast<size_t>(e.robot.tree.find_joint("left_knee"))].back(), 0.08, 1e-3);
  }
}

// A waist that pitches carries the trunk, 9.66 of 36.9 kg with its centre 0.169 m above: 0.0443 m of the robot's centre per rad.
TEST(NextStance, AHeavyLimbSwingsLessThanALightOne) {
  Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  e.robot.tree.joint(e.robot.tree.find_joint("waist")).axis_F = Vector3d::UnitY();
  const Limits limits = make_limits(e, {});
  MotionPlan plan;
  plan.family = Family::kSwing, plan.seed = 2, plan.seconds = 8.0, plan.moves.assign(limits.joints.size(), 1);
  const Commands motion = make_stance_motion(e, plan, limits);
  ASSERT_FALSE(motion.time.empty());
  EXPECT_LT(calc_travel_of(e, motion, "waist"), 2.0 * 0.01 / 0.0443 + 1e-3);  // 1 cm to either side
  EXPECT_GT(calc_travel_of(e, motion, "waist"), 0.05);
}

// Reports name some alternatives without values.
TEST(NextStance, AnAlternativeWithoutValuesIsNotSimulated) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  const Json bare = {{"effect", "com_error"}, {"where", {{"link", "left_thigh"}}}};
  const StanceWorlds worlds = make_stance_worlds(e, make_open_report(bare));
  EXPECT_EQ(worlds.list.size(), 1u);
  EXPECT_NE(worlds.remarks[0].find("com_error@left_thigh"), std::string::npos);
}

// What is wrong with a log changes nothing that the robot does.
TEST(NextStance, AFaultOfALogKeepsNoModelFromBeingSimulated) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  Json report = make_open_report(make_load(1.0, 0.0));
  report["findings"].push_back({{"effect", "sensor_bias"}, {"where", {{"sensor", "/joint_states/left_knee/effort"}}}, {"parameters", {{"value", {{"value", 1.0}}}}}});
  const StanceWorlds worlds = make_stance_worlds(e, report);
  EXPECT_EQ(worlds.list.size(), 2u);  // the soles, and the load in the left one's place
  EXPECT_NE(worlds.remarks[0].find("sensor_bias"), std::string::npos);
}

// Both models have the right sole: its values change the readings of both alike, and are simulated once.
TEST(NextStance, ARivalIsSimulatedOnlyForValuesOfItsOwn) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  const StanceWorlds worlds = make_stance_worlds(e, make_open_report(make_load(1.0, 0.0)));
  ASSERT_EQ(worlds.list.size(), 2u);
  EXPECT_EQ(worlds.list[0].moves.size(), 12u);  // six of each sole
  const auto own = std::count_if(worlds.list[1].moves.begin(), worlds.list[1].moves.end(), [](const StanceMove& m) { return m.shared < 0; });
  EXPECT_EQ(worlds.list[1].moves.size(), 7u);
  EXPECT_EQ(own, 1);  // the mass; a centre of three numbers is not moved
}

// A waist that stood still may have any friction: no mismatch does not mean that nothing is left to learn.
TEST(NextStance, AJointThatStoodStillMayHideFriction) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  Experiment still = e;
  for (Recording& r : still.recordings) {
    JointColumns& waist = r.joints[static_cast<size_t>(e.robot.tree.find_joint("waist"))];
    for (auto* column : {&waist.command, &waist.signal[0]}) std::fill(column->begin(), column->end(), 0.0);
  }
  const StanceWorlds worlds = make_stance_worlds(still, {{"verdict", "no_mismatch"}, {"findings", Json::array()}});
  EXPECT_TRUE(worlds.unseen);
  ASSERT_GE(worlds.list.size(), 2u);
  EXPECT_EQ(worlds.list[0].label, "nothing");
  EXPECT_TRUE(std::any_of(worlds.list.begin(), worlds.list.end(), [](const StanceWorld& w) { return w.label == "coulomb_friction@waist"; }));
}

// A body that is thrown aside leaves no doubt.
TEST(NextStance, AMotionThatTipsTheRobotIsAFault) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  const Limits limits = make_limits(e, {});
  MotionPlan plan;
  plan.family = Family::kLean, plan.size = 3.0, plan.seconds = 4.0;
  Commands motion = make_stance_motion(e, plan, limits);
  ASSERT_FALSE(motion.time.empty());
  EXPECT_NE(run_stance(e, make_truth(e), motion, limits).fault, "");
}

}  // namespace
}  // namespace hrp::diagnosis
