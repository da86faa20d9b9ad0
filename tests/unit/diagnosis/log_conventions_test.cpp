// SPDX-License-Identifier: BSD-3-Clause
// Drivers that count from another pose than the URDF, or with the other sign: told from loads and forces, which look
// alike.
#include <gtest/gtest.h>

#include "common/base/diagnostics.h"
#include "diagnosis/conventions/log_conventions.h"
#include "diagnosis/data/stretches.h"
#include "diagnosis/diagnose_recordings.h"
#include "tests/catch_complaint.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

// Logs of an arm with friction and rotors, driven by its efforts, as another driver would write them.
Experiment make_logged(const std::string& name, int joint, double offset, double sign,
                       Hypothesis hidden = make_arm_drives()) {
  Experiment e = simulate_arm(name, hidden);
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) {
    JointColumns& columns = r.joints[static_cast<size_t>(joint)];
    for (double& q : columns.signal[0]) q = sign * q + offset;
    for (int other : {1, 2}) {
      for (double& x : columns.signal[other]) x *= sign;
    }
  }
  return e;
}

void expect_named_zero(double offset) {
  Experiment e = make_logged("zero_off", kShoulder, offset, 1.0);
  for (Recording& r : e.recordings) r = cut_recording(r, 0, r.time.size() * 2 / 3);  // 4 s tell it
  const Reports reports = diagnose_recordings(
      e, {}, [](const std::string&) {}, [](const Reports&) {});
  double named = 0.0;
  for (const Json& f : reports.report["findings"]) {
    if (f["effect"] == "joint_offset" && f["where"]["joint"] == "shoulder") named = f["parameters"]["offset"]["value"];
    EXPECT_NE(f["effect"], "external_force") << f["statement"];
  }
  // 0.03 rad: what friction near rest moves the zero by; three times the spread between recordings.
  EXPECT_NEAR(named, offset, 0.03) << reports.report["findings"].dump(1);
}

// Small zeros are found by a linear term, large ones before anything else: the report says the same.
TEST(LogConventions, AZeroThatIsOffIsNamedWithItsSizeAndNoForceIs) { expect_named_zero(0.25); }
TEST(LogConventionsNightly, AZeroThatIsOffByAQuarterTurnIsNamedWithItsSizeAndNoForceIs) { expect_named_zero(M_PI / 2); }

// What the report says of a zero of the elbow.
Json report_zero(double offset) {
  LogConventions found;
  found.zeros = {{kElbow, offset, 0.01, false}};
  Reports reports;
  reports.report = {{"findings", Json::array()}, {"warnings", Json::array()}, {"model", Json::array()}};
  add_conventions(make_logged("zero_or_centre", kElbow, offset, 1.0), found, &reports);
  return reports.report["findings"][0];
}

// The elbow carries the forearm alone: with another zero, and with its centre of mass turned about the axis, it moves
// the same weight by the same torque. By a quarter turn nobody misplaces a centre of mass.
TEST(LogConventions, AZeroOfTheLastJointHasItsLinksTurnedCentreOfMassAsAlternative) {
  const Json small = report_zero(0.25), large = report_zero(M_PI / 2);
  EXPECT_EQ(small["grade"], "ambiguous");
  ASSERT_EQ(small["alternatives"].size(), 1u) << small.dump(1);
  EXPECT_EQ(small["alternatives"][0]["effect"], "com_error");
  EXPECT_EQ(small["alternatives"][0]["where"]["link"], "fore");
  const Json offset = small["alternatives"][0]["parameters"]["offset"]["value"];
  EXPECT_NEAR(offset[0].get<double>(), 0.15 * (std::cos(0.25) - 1.0), 1e-9);
  EXPECT_NEAR(offset[2].get<double>(), 0.15 * std::sin(0.25), 1e-9);  // turned back by what it reads too much
  EXPECT_EQ(large["grade"], "supported");
  EXPECT_TRUE(large["alternatives"].empty());
}

// At half a turn, the weight's torque has the other sign; the sign of the effort is right.
TEST(LogConventions, AZeroThatIsOffByHalfATurnIsNoEffortOfTheWrongSign) {
  const LogConventions found = find_conventions(make_logged("half_a_turn", kShoulder, M_PI, 1.0), 1);
  EXPECT_TRUE(found.units.empty());
  ASSERT_EQ(found.zeros.size(), 1u);
  EXPECT_EQ(found.zeros[0].joint, kShoulder);
  EXPECT_NEAR(std::abs(found.zeros[0].offset), M_PI, 0.03);  // what friction near rest moves the zero by
}

TEST(LogConventions, AnAxisThatTurnsTheOtherWayIsRefusedWithItsColumn) {
  try {
    find_conventions(make_logged("turned_axis", kElbow, 0.0, -1.0), 1);
    FAIL() << "the turned axis was not seen";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("axis"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("/joint_states/"), std::string::npos) << error.what();
  }
}

// What the tool says of it, as a user reads it. Empty if it takes the recordings.
std::string refuse(const Experiment& e) {
  return catch_complaint([&] { find_conventions(e, 1); });
}

// An arm on a turntable: its first axis is plumb, so that no zero stands for the way it is mounted.
Experiment make_table(const std::string& name, double friction = 0.5) {
  const std::string urdf = R"(<robot name="table"><link name="base"/>
  <link name="turn"><inertial><origin xyz="0 0 0.1"/><mass value="3"/>
    <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
  <link name="arm"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.03"/></inertial></link>
  <joint name="table" type="revolute"><parent link="base"/><child link="turn"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="50" velocity="10"/></joint>
  <joint name="lift" type="revolute"><parent link="turn"/><child link="arm"/><origin xyz="0.1 0 0.2"/>
    <axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="50" velocity="10"/></joint></robot>)";
  Experiment e = make_simulated_experiment(name, urdf, {"table", "lift"},
                                           {{EffectId::kViscous, 0, {friction}}, {EffectId::kViscous, 1, {friction}}});
  e.scenario.drive = "effort";
  return e;
}

TEST(LogConventions, AnArmOnAWallIsRefusedWithItsGravity) {
  Experiment e = make_table("on_a_wall");
  EXPECT_FALSE(find_conventions(e, 1).any());
  e.scenario.gravity_W = Vector3d(0.0, -9.81, 0.0);
  EXPECT_NE(refuse(e).find("-9.81] m/s^2"), std::string::npos) << refuse(e);
}

// Where there is little friction, weight that acts the other way is an effort of the wrong sign, if one joint is asked.
TEST(LogConventions, AnArmBelowACeilingHasNoEffortOfTheWrongSign) {
  Experiment e = make_table("below_a_ceiling", 0.05);
  e.scenario.gravity_W = Vector3d(0.0, 0.0, 9.81);
  EXPECT_NE(refuse(e).find("-9.81] m/s^2"), std::string::npos) << refuse(e);
}

// Along less than a cycle, friction and a constant of each joint hide which gravity fits by least squares.
TEST(LogConventions, AShortLogTellsTheAxisAlongWhichGravityActs) {
  Experiment e = make_table("mounted_short");
  for (Recording& r : e.recordings) r = cut_recording(r, 0, r.time.size() / 8);
  EXPECT_EQ(refuse(e), "");
  e.scenario.gravity_W = Vector3d(9.81, 0.0, 0.0);
  EXPECT_NE(refuse(e).find("[0, 0, -9.81] m/s^2"), std::string::npos) << refuse(e);
}

void turn_all_efforts(Experiment* e) {
  for (Recording& r : e->recordings) {
    for (JointColumns& joint : r.joints) {
      for (double& y : joint.signal[2]) y = -y;
    }
  }
}

// Joints whose effort is taken with the other sign.
std::vector<int> list_turned(const Experiment& e) {
  std::vector<int> joints;
  for (const TurnedEffort& t : find_conventions(e, 1).signs) joints.push_back(t.joint);
  return joints;
}

TEST(LogConventions, AnEffortOfTheWrongSignIsJudgedWithTheOtherSign) {
  Experiment e = make_table("signs_turned");
  turn_all_efforts(&e);
  EXPECT_EQ(list_turned(e), (std::vector<int>{0, 1}));
}

// Some drives count the torque on the motor, not on the link.
TEST(LogConventions, ATurnedSignIsThatOfOneEffortOrOfAllWhicheverExplainsMore) {
  Experiment e = make_logged("all_signs_turned", kShoulder, 0.0, 1.0);
  turn_all_efforts(&e);
  EXPECT_EQ(list_turned(e), (std::vector<int>{kShoulder, kElbow}));
  e = make_logged("one_sign_turned", kShoulder, 0.0, 1.0);
  for (Recording& r : e.recordings) {
    for (double& y : r.joints[kShoulder].signal[2]) y = -y;
  }
  EXPECT_EQ(list_turned(e), std::vector<int>{kShoulder});
}

TEST(LogConventions, ATurnedSignIsAFindingThatNamesItsJoint) {
  Experiment e = make_table("sign_found");
  turn_all_efforts(&e);
  LogConventions found;
  found.signs = {{1}};
  Reports reports;
  reports.report = {{"findings", Json::array()}, {"warnings", Json::array()}, {"model", Json::array()}};
  add_conventions(e, found, &reports);
  const Json f = reports.report["findings"].at(0);
  EXPECT_EQ(f["where"]["sensor"], "/joint_states/lift/effort");
  EXPECT_EQ(f["parameters"]["scale"]["value"], -1.0);
  EXPECT_GT(f["share"], 0.5);
  EXPECT_NE(f["statement"].get<std::string>().find("lift: the recorded effort has the opposite sign"),
            std::string::npos);
}

// What a report says of a log with a turned sign, if the search in the converted recordings said this.
std::string judge_turned(const char* of_search) {
  LogConventions found;
  found.signs = {{1}};
  Reports reports;
  reports.report = {
      {"verdict", of_search}, {"findings", Json::array()}, {"warnings", Json::array()}, {"model", Json::array()}};
  add_conventions(make_table("sign_judged"), found, &reports);
  return reports.report["verdict"];
}

TEST(LogConventions, ALogWhoseOnlyFaultIsATurnedSignIsExplained) {
  EXPECT_EQ(judge_turned("no_mismatch"), "explained");
  EXPECT_EQ(judge_turned("unexplained"), "partly_explained");
  EXPECT_EQ(judge_turned("mostly_explained"), "mostly_explained");
}

TEST(LogConventions, FrictionAndRotorsNeedNoOtherZero) {
  EXPECT_FALSE(find_conventions(make_logged("no_zero", kShoulder, 0.0, 1.0), 1).any());
}

TEST(LogConventions, ALoadInTheHandIsNoOtherZero) {
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kPayload, kFore, {0.8, 0.3, 0.0, 0.0, 0.0}});
  EXPECT_FALSE(find_conventions(make_logged("load_no_zero", kShoulder, 0.0, 1.0, hidden), 1).any());
}

// A load beside the line from joint to centre of mass turns that line, as a zero of the joint does. Its inertia, taken
// where it hangs, tells it.
TEST(LogConventions, ALoadBesideTheForearmIsNoOtherZero) {
  const Hypothesis hidden{{EffectId::kPayload, kFore, {0.5, 0.0, 0.0, 0.15, 0.0}}};
  EXPECT_TRUE(find_conventions(make_logged("load_beside_no_zero", kShoulder, 0.0, 1.0, hidden), 1).zeros.empty());
}

TEST(LogConventions, ASidewaysForceIsNoOtherZero) {
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kExternalForce, kFore, {6.0, 0.0, 0.0}});
  EXPECT_FALSE(find_conventions(make_logged("force_no_zero", kShoulder, 0.0, 1.0, hidden), 1).any());
}

}  // namespace
}  // namespace hrp::diagnosis
