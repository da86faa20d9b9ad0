// SPDX-License-Identifier: BSD-3-Clause
// Loads that somebody hung on a robot in one recording, and hands that pulled at it.
#include <gtest/gtest.h>

#include <algorithm>

#include "common/base/diagnostics.h"
#include "diagnosis/data/by_hand.h"
#include "diagnosis/measurement/torque/torque.h"
#include "diagnosis/next/hung_loads.h"
#include "diagnosis/next/propose.h"
#include "diagnosis/report/report.h"
#include "diagnosis/simulation/bodies.h"
#include "tests/catch_complaint.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

const Progress kQuietly = [](const std::string&) {};

// A single link that turns about y: its weight and its drive's constant are one number.
constexpr const char* kPendulum = R"(<robot name="pendulum"><link name="base"/>
  <link name="arm"><inertial><origin xyz="0.3 0 0"/><mass value="3"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.05"/></inertial></link>
  <link name="flange"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="50" velocity="10"/></joint>
  <joint name="tool" type="fixed"><parent link="arm"/><child link="flange"/><origin xyz="0.5 0 0"/></joint></robot>)";

LoadSpec make_load(const std::string& link, double mass, const Vector3d& p) { return {link, mass, p}; }

HandPush make_pull(const std::string& link, const Vector3d& force_W, const Vector3d& p) {
  HandPush push;
  push.link = link;
  push.known = true;
  push.force_W = force_W;
  push.p_LQ = p;
  return push;
}

RecordingSpec make_spec(const std::vector<LoadSpec>& loads, const std::vector<HandPush>& pushes) {
  RecordingSpec spec;
  spec.loads = loads;
  spec.pushes = pushes;
  return spec;
}

// Efforts at rest [N m].
Eigen::VectorXd calc_holding(const Plant& plant, const Eigen::VectorXd& q) {
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(1, q.size());
  return calc_efforts(plant, q.transpose(), none, none).row(0);
}

TEST(ByHand, AHungLoadIsAPayloadOfThatRecordingOnly) {
  const Experiment e = simulate_arm("by_hand_payload", {});
  const Plant with = make_plant(e, {}, make_spec({make_load("fore", 1.0, {0.25, 0, 0})}, {}));
  const Plant payload = make_plant(e, {{EffectId::kPayload, kFore, {1.0, 0.25, 0.0, 0.0, 0.0}}});
  const Eigen::VectorXd q = Eigen::Vector2d(0.4, -0.7);
  EXPECT_LT((calc_holding(with, q) - calc_holding(payload, q)).norm(), 1e-12);
  // Horizontal arm: 1 kg 0.25 m and 0.65 m beyond the joints about y, whose positive torque lowers what is ahead.
  const Eigen::VectorXd more =
      calc_holding(with, Eigen::Vector2d::Zero()) - calc_holding(make_plant(e, {}), Eigen::Vector2d::Zero());
  EXPECT_NEAR(more[kElbow], -9.81 * 0.25, 1e-9);
  EXPECT_NEAR(more[kShoulder], -9.81 * 0.65, 1e-9);
}

// What hangs on a link that is 20 % heavier than stated is not 20 % heavier.
TEST(ByHand, AWrongMassOfTheLinkLeavesTheLoadAsItIs) {
  const Experiment e = simulate_arm("by_hand_mass", {});
  const Hypothesis heavy{{EffectId::kMassError, kFore, {1.2}}};
  const RecordingSpec spec = make_spec({make_load("fore", 1.0, {0.25, 0, 0})}, {});
  const Eigen::VectorXd q = Eigen::Vector2d(0.3, 0.2);
  const Eigen::VectorXd by_load = calc_holding(make_plant(e, {}, spec), q) - calc_holding(make_plant(e, {}), q);
  const Eigen::VectorXd by_load_on_heavy =
      calc_holding(make_plant(e, heavy, spec), q) - calc_holding(make_plant(e, heavy), q);
  EXPECT_LT((by_load - by_load_on_heavy).norm(), 1e-12);
}

TEST(ByHand, APullTurnsAJointByForceTimesLever) {
  const Experiment e = simulate_arm("by_hand_pull", {});
  // 10 N upwards, 0.3 m beyond the elbow, 0.7 m beyond the shoulder: the drives hold less of the weight.
  const Plant pulled = make_plant(e, {}, make_spec({}, {make_pull("fore", {0, 0, 10}, {0.3, 0, 0})}));
  const Eigen::VectorXd less =
      calc_holding(pulled, Eigen::Vector2d::Zero()) - calc_holding(make_plant(e, {}), Eigen::Vector2d::Zero());
  EXPECT_NEAR(less[kElbow], 3.0, 1e-9);
  EXPECT_NEAR(less[kShoulder], 7.0, 1e-9);
}

// Recordings of `hidden`, the last `loaded` of which hang with `load`; every other one is held out.
Experiment make_loaded_experiment(const std::string& name, const Hypothesis& hidden,
                                  const std::vector<LoadSpec>& loads) {
  Experiment e = make_simulated_experiment(name, kPendulum, {"shoulder"}, {});
  TestNoise noise;
  const double sigma[] = {2e-5, 0.002, 0.02};
  std::vector<Recording> all = e.recordings;
  if (!loads.empty()) {
    all.push_back(e.recordings[0]);
    all.push_back(e.recordings[2]);
    for (size_t r = 3; r < all.size(); ++r) all[r].spec.loads = loads;
  }
  for (Recording& r : all) {
    SmoothRecording still = smooth_recording(e, r);
    std::vector<double> y;
    RolloutOptions fine;
    fine.max_step = 0.0002;
    fine.free_running = true;
    still.start = 0;
    EXPECT_TRUE(simulate_recording(make_plant(e, hidden, r.spec), r, still, fine, &y));
    for (size_t k = 0; k < r.size(); ++k) {
      for (size_t c = 0; c < 3; ++c) r.joints[0].signal[c][k] = y[k * 3 + c] + sigma[c] * noise.draw();
    }
  }
  e.recordings = std::move(all);
  return e;
}

TEST(ByHand, NoTorqueIsMissingWhereAStatedLoadHangs) {
  const std::vector<LoadSpec> loads{make_load("arm", 1.0, {0.5, 0, 0})};
  Experiment e = make_loaded_experiment("by_hand_torque", {}, loads);
  const auto calc_missing = [&] {
    double sum = 0.0, n = 0.0;
    for (const TorqueRecording& r : make_torque_data(e).recordings) {
      if (r.index >= 3) {
        sum += r.missing.squaredNorm();
        n += static_cast<double>(r.missing.size());
      }
    }
    return std::sqrt(sum / n);
  };
  EXPECT_LT(calc_missing(), 0.05);  // noise of efforts is 0.02 N m, that of accelerations comes on top
  for (Recording& r : e.recordings) r.spec.loads.clear();
  EXPECT_GT(calc_missing(), 1.0);  // 1 kg at 0.5 m is up to 4.9 N m
}

bool names(const Json& list, const std::string& effect) {
  return std::any_of(list.begin(), list.end(), [&](const Json& f) { return f["effect"] == effect; });
}

TEST(ByHand, AHungKilogramDecidesBetweenAMassAndATorqueConstant) {
  const Hypothesis weak{{EffectId::kTorqueConstant, 0, {0.9}}};
  Experiment open = make_loaded_experiment("by_hand_open", weak, {});
  const Json before = diagnose(make_problem(open, 1), kQuietly).report;
  Json doubt = before["findings"];
  for (const Json& f : before["findings"]) {
    for (const Json& other : f["alternatives"]) doubt.push_back(other);
  }
  EXPECT_TRUE(names(doubt, "mass_error") && names(doubt, "torque_constant_error")) << before["findings"].dump(1);
  Experiment loaded = make_loaded_experiment("by_hand_decided", weak, {make_load("arm", 1.0, {0.5, 0, 0})});
  const Json after = diagnose(make_problem(loaded, 1), kQuietly).report;
  ASSERT_EQ(after["findings"].size(), 1u) << after["findings"].dump(1);
  EXPECT_EQ(after["findings"][0]["effect"], "torque_constant_error");
  EXPECT_NE(after["findings"][0]["grade"], "ambiguous");
  EXPECT_FALSE(names(after["findings"][0]["alternatives"], "mass_error")) << after["findings"].dump(1);
}

TEST(ByHand, AStretchWithAnUnknownForceIsLeftOut) {
  Experiment e = simulate_arm("by_hand_unknown", {});
  HandPush push;
  push.start = 2.0;
  push.end = 3.0;
  e.recordings[0].spec.pushes = {push};
  std::vector<std::string> warnings;
  const std::vector<Recording> pieces = cut_at_pushes(e, e.recordings[0], &warnings);
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_LT(pieces[0].time.back(), 1.75);  // a hand that comes 0.3 s earlier is no surprise
  EXPECT_GT(pieces[1].time.front(), 3.25);
  for (const Recording& piece : pieces) EXPECT_TRUE(piece.spec.pushes.empty());
  EXPECT_EQ(warnings.size(), 1u);
}

TEST(ByHand, AKnownForceActsInItsOwnPieceOnly) {
  Experiment e = simulate_arm("by_hand_known", {});
  HandPush pull = make_pull("fore", {0, 5, 0}, {0.3, 0, 0});
  pull.start = 3.0;
  e.recordings[0].spec.pushes = {pull};
  std::vector<std::string> warnings;
  const std::vector<Recording> pieces = cut_at_pushes(e, e.recordings[0], &warnings);
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_TRUE(pieces[0].spec.pushes.empty());
  ASSERT_EQ(pieces[1].spec.pushes.size(), 1u);
  EXPECT_GT(pieces[1].time.front(), 3.25);
}

// The frame of a link that is fixed to another, 0.5 m ahead of it.
TEST(ByHand, ALoadAtAFixedLinkHangsOnWhatMovesWithIt) {
  Experiment e = make_simulated_experiment("by_hand_flange", kPendulum, {"shoulder"}, {});
  e.recordings[0].spec.loads = {make_load("flange", 1.0, {0, 0, -0.1})};
  resolve_by_hand(e, &e.recordings[0]);
  EXPECT_EQ(e.recordings[0].spec.loads[0].link, "arm");
  EXPECT_LT((e.recordings[0].spec.loads[0].p_LC - Vector3d(0.5, 0, -0.1)).norm(), 1e-12);
  e.recordings[1].spec.loads = {make_load("hand", 1.0, Vector3d::Zero())};
  EXPECT_THROW(resolve_by_hand(e, &e.recordings[1]), InputError);
}

// A link 10 % heavier, or a drive that gives a tenth less: the recordings cannot say.
Json make_open_report() {
  const Json mass = {
      {"effect", "mass_error"}, {"where", {{"link", "arm"}}}, {"parameters", {{"scale", {{"value", 1.111}}}}}};
  Json weak = {{"effect", "torque_constant_error"},
               {"where", {{"joint", "shoulder"}}},
               {"parameters", {{"scale", {{"value", 0.9}}}}}};
  weak["grade"] = "ambiguous";
  weak["alternatives"] = {mass};
  return {{"verdict", "mostly_explained"}, {"findings", {weak}}};
}

Next propose_for(const Experiment& e, const std::vector<std::string>& limits) {
  NextOptions options;
  options.seconds = 5.0;
  options.count = 1;
  options.limits = limits;
  return propose(e, make_open_report(), options, kQuietly);
}

double find_probability(const Next& next) {
  for (const Expected& one : next.proposals.at(0).expected) {
    if (one.label == "mass_error@arm") return one.probability;
  }
  return -1.0;
}

TEST(ByHand, TheProposalAsksForALoadWhereOnlyAKnownWeightDecides) {
  const Experiment e = make_loaded_experiment("by_hand_next", {{EffectId::kTorqueConstant, 0, {0.9}}}, {});
  const Next next = propose_for(e, {});
  ASSERT_EQ(next.proposals.size(), 1u) << next.nothing;
  ASSERT_EQ(next.proposals[0].plan.loads.size(), 1u);
  EXPECT_GT(find_probability(next), 0.9);
  const Next bare = propose_for(e, {"load=0"});
  ASSERT_EQ(bare.proposals.size(), 1u) << bare.nothing;
  EXPECT_TRUE(bare.proposals[0].plan.loads.empty());
  EXPECT_LT(find_probability(bare), 0.1);
}

TEST(ByHand, LoadsAreMassesThatPeopleHaveAndAQuarterOfWhatMovesAtMost) {
  const Experiment e = simulate_arm("by_hand_masses", {});
  const std::vector<LoadSpec> loads = list_hung_loads(e.robot.tree, 100.0);
  ASSERT_EQ(loads.size(), 1u);
  EXPECT_EQ(loads[0].link, "fore");
  EXPECT_DOUBLE_EQ(loads[0].mass, 0.5);  // of 3 kg
  EXPECT_DOUBLE_EQ(list_hung_loads(e.robot.tree, 0.3).at(0).mass, 0.2);
  EXPECT_TRUE(list_hung_loads(e.robot.tree, 0.0).empty());
}

// The shoulder holds 9.8 N m of itself; with the load it would need more than it may give, without it does not.
TEST(ByHand, ALoadThatADriveMayNotHoldIsNotAskedFor) {
  const Experiment e = make_loaded_experiment("by_hand_effort", {{EffectId::kTorqueConstant, 0, {0.9}}}, {});
  const Next next = propose_for(e, {"effort=10.2"});
  for (const Proposal& p : next.proposals) EXPECT_TRUE(p.plan.loads.empty());
}

std::string find_fault(const std::string& entry) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / "hrp_by_hand_keys";
  fs::create_directories(folder);
  std::ofstream(folder / "a.csv") << "time\n";
  return catch_complaint([&] {
    parse_experiment_keys("recordings:\n- {file: a.csv, " + entry + "}\n", (folder / "experiment.yaml").string());
  });
}

TEST(ByHand, WhatIsNotStatedWholeIsRefusedByName) {
  EXPECT_EQ(find_fault("loads: [{link: hand, mass: 1, com: [0, 0, 0.1]}], pushes: [{start: 1, duration: 2}]"), "");
  EXPECT_EQ(find_fault("pushes: [{link: hand, force: [0, 0, 5], xyz: [0, 0, 0]}]"), "");
  EXPECT_NE(find_fault("loads: [{link: hand, mass: 1}]").find("com"), std::string::npos);
  EXPECT_NE(find_fault("loads: [{link: hand, mass: -1, com: [0, 0, 0]}]").find("more than 0 kg"), std::string::npos);
  EXPECT_NE(find_fault("loads: [{link: hand, weight: 1, com: [0, 0, 0]}]").find("weight"), std::string::npos);
  EXPECT_NE(find_fault("pushes: [{link: hand}]").find("'start' and 'duration'"), std::string::npos);
  EXPECT_NE(find_fault("pushes: [{force: [0, 0, 5]}]").find("link"), std::string::npos);
  EXPECT_NE(find_fault("pushes: [{start: 2, duration: 0}]").find("more than 0 s"), std::string::npos);
}

}  // namespace
}  // namespace hrp::diagnosis
