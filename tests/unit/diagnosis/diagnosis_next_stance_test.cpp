// SPDX-License-Identifier: BSD-3-Clause
// The next experiment of a robot on its feet: what is proposed keeps it there, whichever explanation holds.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "diagnosis/next/limits.h"
#include "diagnosis/next/propose.h"
#include "diagnosis/next/stance_logs.h"
#include "diagnosis/next/stance_motions.h"
#include "diagnosis/next/stance_trial.h"
#include "diagnosis/next/stance_worlds.h"
#include "diagnosis/report/report.h"
#include "tests/test_places.h"

namespace hrp::diagnosis {
namespace {

const std::string kFolder = source_dir() + "/models/experiments/";
const Progress kQuietly = [](const std::string&) {};

Json make_sole(const std::string& foot, double stiffness) {
  Json parameters;
  for (const auto& [name, value] : {std::pair{"kz", 2e5},
                                    {"cz", 1000.0},
                                    {"k_roll", 0.7 * stiffness},
                                    {"c_roll", 4.0},
                                    {"k_pitch", stiffness},
                                    {"c_pitch", 5.0}})
    parameters[name] = {{"value", value}};
  return {{"effect", "foot_compliance"}, {"where", {{"foot", foot}}}, {"parameters", parameters}};
}

// `forward` [m] of the trunk.
Json make_load(double mass, double forward) {
  return {{"effect", "payload"},
          {"where", {{"link", "trunk"}}},
          {"parameters", {{"mass", mass}, {"com", {forward, 0.0, 0.1}}}}};
}

Json make_finding(const char* effect, const Json& where, const Json& values) {
  Json parameters = Json::object();
  for (const auto& [name, value] : values.items()) parameters[name] = {{"value", value}};
  return {{"effect", effect}, {"where", where}, {"parameters", parameters}};
}

// "The left sole gives, or there is a load on the trunk"; the right one gives as well.
Json make_open_report(const Json& load) {
  Json left = make_sole("left_sole_link", 420.0), right = make_sole("right_sole_link", 390.0);
  left["alternatives"] = Json::array({load});
  return {{"verdict", "partly_explained"}, {"findings", {left, right}}};
}

NextOptions make_options() {
  NextOptions options;
  options.seconds = 4.0;
  options.count = 1;
  options.jobs = 2;
  return options;
}

// What the experiment's recordings really hide; no explanation has these values.
Scenario make_truth(const Experiment& e) {
  std::ifstream file(kFolder + "answers/standing.json");
  nlohmann::json effects = nlohmann::json::array();
  for (nlohmann::json hidden : nlohmann::json::parse(file)["hidden"]) {
    const nlohmann::json foot = hidden["foot"];
    hidden.erase("effect");
    hidden.erase("foot");
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

// The report itself says that the robot carries 20 kg far in front.
Json make_heavy_report() {
  Json load = make_load(20.0, 0.6);
  load["alternatives"] = Json::array({make_sole("left_sole_link", 420.0)});
  return {{"verdict", "partly_explained"}, {"findings", {load, make_sole("right_sole_link", 390.0)}}};
}

TEST(NextStance, NothingIsProposedThatTheReportsModelWouldFallIn) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  const Next next = propose(e, make_heavy_report(), make_options(), kQuietly);
  EXPECT_TRUE(next.proposals.empty());
  EXPECT_NE(next.nothing, "");
  EXPECT_FALSE(next.rejected.empty());
}

// The real robot stood: a load with which it cannot stand is none, and keeps no motion from being proposed.
TEST(NextStance, AnAlternativeInWhichTheRobotCannotStandIsLeftOut) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  const Next next = propose(e, make_open_report(make_load(20.0, 0.6)), make_options(), kQuietly);
  EXPECT_EQ(next.explanations.size(), 1u);
  EXPECT_TRUE(std::any_of(next.remarks.begin(), next.remarks.end(), [](const std::string& remark) {
    return remark.find("does not stand at rest") != std::string::npos;
  }));
}

// Motions of up to four sizes. One model is safe at none of them: only the first size of a motion is simulated under
// both.
TEST(NextStance, ASmallerSizeIsFirstTriedWhereTheLargerOneFailed) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  const Next next = propose(e, make_heavy_report(), make_options(), kQuietly);
  EXPECT_LE(next.simulated, next.tried * (4 + 1));
}

// Two numbers at each of 13 joints: in a dirty world no one could wait for each at either end.
TEST(NextStance, OfManyValuesTheLeastCertainGoToTheirEndsAloneAndTheRestTogether) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  Json findings = Json::array();
  for (int j = 0; j < e.num_joints(); ++j) {
    const Json where{{"joint", e.robot.tree.joint(j).name}};
    findings.push_back(make_finding("viscous_friction", where, {{"coefficient", 1.0}}));
    findings.push_back(make_finding("coulomb_friction", where, {{"level", 1.0}}));
  }
  const StanceWorlds worlds = make_stance_worlds(e, {{"verdict", "explained"}, {"findings", findings}});
  ASSERT_GT(findings.size(), 12u);
  EXPECT_EQ(worlds.values.size(), 12u);
  EXPECT_EQ(worlds.ends.size(), 2u * 12u + 2u + 1u);  // and the nominal model
}

TEST(NextStance, TheBodyMovesAndTheSolesStay) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  const Limits limits = make_limits(e, {});
  for (int f = static_cast<int>(Family::kSway); f < static_cast<int>(Family::kWalk); ++f) {
    MotionPlan plan;
    plan.family = static_cast<Family>(f);
    plan.size = 0.5;
    plan.seconds = 4.0;
    plan.moves.assign(limits.joints.size(), 1);
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
  plan.family = Family::kSwing;
  plan.seconds = 4.0;
  EXPECT_TRUE(make_stance_motion(e, plan, limits).time.empty());  // nothing may move
  plan.moves.assign(limits.joints.size(), 1);
  const Commands motion = make_stance_motion(e, plan, limits);
  ASSERT_FALSE(motion.time.empty());
  EXPECT_GT(calc_travel_of(e, motion, "waist"), 0.2);
  EXPECT_LT(calc_travel_of(e, motion, "left_ankle_roll"), 1e-9);
}

// With soles that stay, hip yaws turn only if the body does.
TEST(NextStance, ATurnOfTheBodyMovesTheHipYaws) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  const Limits limits = make_limits(e, {});
  MotionPlan plan;
  plan.family = Family::kTurn;
  plan.seconds = 4.0;
  plan.moves.assign(limits.joints.size(), 1);
  const Commands motion = make_stance_motion(e, plan, limits);
  ASSERT_FALSE(motion.time.empty());
  for (const char* joint : {"left_hip_yaw", "right_hip_yaw"}) EXPECT_GT(calc_travel_of(e, motion, joint), 0.1) << joint;
  EXPECT_EQ(run_stance(e, make_truth(e), motion, limits).fault, "");
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
    plan.family = family;
    plan.size = 0.5;
    plan.seconds = 6.0;
    plan.moves.assign(limits.joints.size(), 1);
    const Commands motion = make_stance_motion(e, plan, limits);
    ASSERT_FALSE(motion.time.empty()) << get_family_word(family);
    EXPECT_GT(calc_travel_of(e, motion, "left_knee"), 0.1);
    EXPECT_NEAR(motion.position[static_cast<size_t>(e.robot.tree.find_joint("left_knee"))].back(), 0.08, 1e-3);
  }
}

// A waist that pitches carries the trunk, 9.66 of 36.9 kg with its centre 0.169 m above: 0.0443 m of the robot's centre
// per rad.
TEST(NextStance, AHeavyLimbSwingsLessThanALightOne) {
  Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  e.robot.tree.joint(e.robot.tree.find_joint("waist")).axis_F = Vector3d::UnitY();
  const Limits limits = make_limits(e, {});
  MotionPlan plan;
  plan.family = Family::kSwing;
  plan.seed = 2;
  plan.seconds = 8.0;
  plan.moves.assign(limits.joints.size(), 1);
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

Json make_log_bias(double bias) {
  return make_finding("sensor_bias", {{"sensor", "/joint_states/left_knee/effort"}}, {{"value", bias}});
}

// What is wrong with a log changes nothing that the robot does.
TEST(NextStance, AFaultOfALogKeepsNoModelFromBeingSimulated) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  Json report = make_open_report(make_load(1.0, 0.0));
  report["findings"].push_back(make_log_bias(1.0));
  const StanceWorlds worlds = make_stance_worlds(e, report);
  ASSERT_EQ(worlds.list.size(), 2u);  // the soles, and the load in the left one's place
  EXPECT_EQ(worlds.list[1].faults.size(), 1u);
}

// A sensor of the base is not among the readings that motions are compared by.
TEST(NextStance, AFaultThatNoReadingShowsIsLeftOut) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  Json report = make_open_report(make_load(1.0, 0.0));
  report["findings"].push_back(make_finding("sensor_delay", {{"sensor", "/imu/imu/orientation"}}, {{"delay", 0.004}}));
  const StanceWorlds worlds = make_stance_worlds(e, report);
  EXPECT_EQ(worlds.list.size(), 2u);
  EXPECT_NE(worlds.remarks[0].find("sensor_delay"), std::string::npos);
}

// At one posture both are a constant torque: the spring of 60 N m/rad acts over the knee's way, the bias does not.
TEST(NextStance, ASpringIsToldFromABiasOfTheLogByAMotionOfItsJoint) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  Json spring = make_finding("parallel_spring", {{"joint", "left_knee"}}, {{"stiffness", 60.0}, {"rest", 0.4}});
  spring["alternatives"] = Json::array({make_log_bias(6.0)});
  const Next next = propose(e, {{"verdict", "explained"}, {"findings", {spring}}}, make_options(), kQuietly);
  ASSERT_EQ(next.explanations.size(), 2u);
  ASSERT_EQ(next.proposals.size(), 1u) << next.nothing;
  ASSERT_EQ(next.proposals[0].expected.size(), 1u);
  EXPECT_GT(next.proposals[0].expected[0].probability, 0.9);
}

// A bias of 2, a scale of 3 and a delay of half a sample of a ramp with slope 1 a sample.
TEST(NextStance, FaultsOfALogChangeOnlyTheirOwnReading) {
  std::vector<double> readings;
  for (int k = 0; k < 4; ++k) {
    readings.push_back(7.0);
    readings.push_back(k);
  }
  LogFault fault;
  fault.channel = 1;
  fault.errors.bias.x() = 2.0;
  fault.errors.scale.x() = 3.0;
  fault.errors.delay = 0.5 * kStretch;
  add_log_faults({fault}, 2, &readings);
  EXPECT_EQ(readings[2], 7.0);
  EXPECT_NEAR(readings[3], 3.0 * 0.5 + 2.0, 1e-12);
  EXPECT_NEAR(readings[5], 3.0 * 1.5 + 2.0, 1e-12);
}

Experiment hold(Experiment e, const char* joint) {
  for (Recording& r : e.recordings) {
    JointColumns& columns = r.joints[static_cast<size_t>(e.robot.tree.find_joint(joint))];
    for (auto* column : {&columns.command, &columns.signal[0]}) std::fill(column->begin(), column->end(), 0.0);
  }
  return e;
}

Experiment hold_waist(Experiment e) { return hold(std::move(e), "waist"); }

bool moves(const Proposal& p, const std::string& joint) {
  return std::find(p.moving.begin(), p.moving.end(), joint) != p.moving.end();
}

// Nobody has seen this joint yet, whatever is wrong elsewhere: both the fitted and the held-out motion have to move it.
TEST(NextStance, AJointThatStoodStillMovesAlsoIfAnotherIsInDoubt) {
  const Experiment e = hold_waist(load_experiment(kFolder + "standing/experiment.yaml"));
  NextOptions options = make_options();
  options.count = 2;
  Json report{{"verdict", "explained"},
              {"findings", {make_finding("viscous_friction", {{"joint", "left_knee"}}, {{"coefficient", 3.0}})}}};
  const Next next = propose(e, report, options, kQuietly);
  ASSERT_EQ(next.proposals.size(), 2u) << next.nothing;
  for (const Proposal& p : next.proposals) EXPECT_TRUE(moves(p, "waist")) << p.file;
}

// A leg's joint that stood still is as unknown as an arm's, as long as something is unexplained.
TEST(NextStance, AHipYawThatStoodStillIsMoved) {
  Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  e = hold(std::move(e), "left_hip_yaw");
  const Json report{{"verdict", "partly_explained"},
                    {"findings", {make_finding("viscous_friction", {{"joint", "left_knee"}}, {{"coefficient", 3.0}})}}};
  const Next next = propose(e, report, make_options(), kQuietly);
  ASSERT_EQ(next.proposals.size(), 1u) << next.nothing;
  EXPECT_TRUE(moves(next.proposals[0], "left_hip_yaw"));
}

// 1.7 degrees sideways: the robot leans, and its soles still have room for a small squat.
TEST(NextStance, AGentleSlopeLeavesASmallSquatSafe) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  const Limits limits = make_limits(e, {});
  MotionPlan plan;
  plan.family = Family::kSquat;
  plan.size = 0.2;
  plan.seconds = 4.0;
  Scenario slope = make_truth(e);
  slope.ground.roll = 0.03;
  EXPECT_EQ(run_stance(e, slope, make_stance_motion(e, plan, limits), limits).fault, "");
}

// A gap of unknown stiffness cannot be simulated. That is no reason to learn nothing.
TEST(NextStance, AModelThatCannotBeSimulatedLeavesTheRestToLearn) {
  const Experiment e = hold_waist(load_experiment(kFolder + "standing/experiment.yaml"));
  const Json play = make_finding("backlash", {{"joint", "left_knee"}}, {{"gap", 0.002}});
  const Next next = propose(e, {{"verdict", "explained"}, {"findings", {play}}}, make_options(), kQuietly);
  ASSERT_EQ(next.proposals.size(), 1u) << next.nothing;
  EXPECT_TRUE(moves(next.proposals[0], "waist"));
}

// A report that only says where something is missing needs a motion most of all.
TEST(NextStance, AJointThatNothingExplainsGetsAMotionThatTellsWhatItsDriveMayHave) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  const std::string effort = e.signal_name(e.robot.tree.find_joint("left_knee"), Quantity::kEffort);
  const Json report{{"verdict", "unexplained"},
                    {"findings", Json::array()},
                    {"unexplained", {{{"where", {{"joint", "left_knee"}}}}}},
                    {"fit", {{"per_signal", {{effort, {{"before", 0.3}, {"after", 0.3}}}}}}}};
  const Next next = propose(e, report, make_options(), kQuietly);
  ASSERT_EQ(next.proposals.size(), 1u) << next.nothing;
  EXPECT_GE(next.explanations.size(), 3u);
  EXPECT_EQ(next.explanations[0], "coulomb_friction@left_knee");
  EXPECT_TRUE(moves(next.proposals[0], "left_knee"));
  EXPECT_GT(next.proposals[0].expected[0].probability, 0.5);
}

// Both models have the right sole: its values change the readings of both alike, and are simulated once.
TEST(NextStance, ARivalIsSimulatedOnlyForValuesOfItsOwn) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  const StanceWorlds worlds = make_stance_worlds(e, make_open_report(make_load(1.0, 0.0)));
  ASSERT_EQ(worlds.list.size(), 2u);
  EXPECT_EQ(worlds.list[0].moves.size(), 12u);  // six of each sole
  const auto own = std::count_if(worlds.list[1].moves.begin(), worlds.list[1].moves.end(),
                                 [](const StanceMove& m) { return m.shared < 0; });
  EXPECT_EQ(worlds.list[1].moves.size(), 7u);
  EXPECT_EQ(own, 1);  // the mass; a centre of three numbers is not moved
}

// A waist that stood still may have any friction: no mismatch does not mean that nothing is left to learn.
TEST(NextStance, AJointThatStoodStillMayHideFriction) {
  const Experiment still = hold_waist(load_experiment(kFolder + "standing/experiment.yaml"));
  const StanceWorlds worlds = make_stance_worlds(still, {{"verdict", "no_mismatch"}, {"findings", Json::array()}});
  EXPECT_TRUE(worlds.unseen);
  ASSERT_GE(worlds.list.size(), 2u);
  EXPECT_EQ(worlds.list[0].label, "nothing");
  EXPECT_TRUE(std::any_of(worlds.list.begin(), worlds.list.end(),
                          [](const StanceWorld& w) { return w.label == "coulomb_friction@waist"; }));
}

// A body that is thrown aside leaves no doubt.
TEST(NextStance, AMotionThatTipsTheRobotIsAFault) {
  const Experiment e = load_experiment(kFolder + "standing/experiment.yaml");
  const Limits limits = make_limits(e, {});
  MotionPlan plan;
  plan.family = Family::kLean;
  plan.size = 3.0;
  plan.seconds = 4.0;
  Commands motion = make_stance_motion(e, plan, limits);
  ASSERT_FALSE(motion.time.empty());
  EXPECT_NE(run_stance(e, make_truth(e), motion, limits).fault, "");
}

}  // namespace
}  // namespace hrp::diagnosis
