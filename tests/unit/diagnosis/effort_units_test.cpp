// SPDX-License-Identifier: BSD-3-Clause
// Logged efforts that are currents: the torque of one logged unit is found beside friction and rotors, joint by joint, and
// what is merely a wrong gain or a heavy load is no unit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/diagnostics.h"
#include "diagnosis/conventions/effort_units.h"
#include "diagnosis/conventions/log_conventions.h"
#include "diagnosis/conventions/unit_doubts.h"
#include "diagnosis/diagnose_recordings.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

std::vector<EffortUnit> find_units(const Experiment& e) { return find_effort_units(make_torque_data(e)); }

TEST(EffortUnits, CurrentsOfDrivesWithFrictionAndRotorsAreToldWithTheirTorqueConstants) {
  const std::vector<double> torque_of_unit{8.0, 5.0};
  const std::vector<EffortUnit> units = find_units(simulate_currents("units_amperes", make_arm_drives(), torque_of_unit));
  ASSERT_EQ(units.size(), 2u);
  for (const EffortUnit& u : units) {
    // A tenth: the two regressions are biased by what dry friction leaves near rest.
    EXPECT_NEAR(u.scale, torque_of_unit[static_cast<size_t>(u.joint)], 0.1 * torque_of_unit[static_cast<size_t>(u.joint)]);
    EXPECT_LE(u.low, u.scale);
    EXPECT_GE(u.high, u.scale);
  }
}

// A disc on a vertical axis: friction, and a rotor of fifty times its inertia, take all of the effort, in whatever unit.
const std::string kDisc = R"(<robot name="disc"><link name="stand"/>
    <link name="disc"><inertial><mass value="0.1"/><inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.002"/></inertial></link>
    <joint name="motor" type="revolute"><parent link="stand"/><child link="disc"/><axis xyz="0 0 1"/>
      <limit lower="-3" upper="3" effort="50" velocity="10"/></joint></robot>)";
// A disc that takes most of its drive's torque, beside dry friction.
Experiment simulate_heavy_disc(const std::string& name) {
  std::string disc = kDisc;
  const std::string light = R"(ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.002")";
  disc.replace(disc.find(light), light.size(), R"(ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.2")");
  Experiment e = make_simulated_experiment(name, disc, {"motor"}, {{EffectId::kCoulomb, 0, {0.3, 0.0, 5e-4}}});
  e.scenario.drive = "effort";
  return e;
}

TEST(EffortUnits, OfAMotorWithoutALoadTheUnitCannotBeChecked) {
  Experiment e = make_simulated_experiment("units_disc", kDisc, {"motor"}, {{EffectId::kCoulomb, 0, {1.0, 0.0, 5e-4}}, {EffectId::kRotorInertia, 0, {0.1}}});
  Experiment arm = simulate_arm("units_told", make_arm_drives());
  e.scenario.drive = arm.scenario.drive = "effort";
  EXPECT_FALSE(tells_unit(make_torque_data(e), 0));
  EXPECT_TRUE(tells_unit(make_torque_data(arm), kShoulder));
}

// A yaw joint below an arm of two joints: no gravity acts on it, and its inertia looks like its rotor's.
const std::string kYawArm = R"(<robot name="yaw_arm"><link name="base"/><link name="column"/>
  <link name="upper"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.03"/></inertial></link>
  <link name="fore"><inertial><origin xyz="0.6 0 0"/><mass value="1"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
  <joint name="yaw" type="revolute"><parent link="base"/><child link="column"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="50" velocity="10"/></joint>
  <joint name="shoulder" type="revolute"><parent link="column"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="50" velocity="10"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.4 0 0"/>
    <axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="50" velocity="10"/></joint></robot>)";

constexpr int kYaw = 0;

// Its currents of 8 N m. Friction over position, in no list, of `hides` N m hides the torque that the yaw joint's motion
// takes, and of `blurs` that of the others.
Experiment make_yaw_currents(const std::string& name, double hides, double blurs) {
  Hypothesis hidden;
  for (int j = 0; j < 3; ++j) {
    hidden.push_back({EffectId::kCoulomb, j, {1.0, 0.0, 5e-4}});
    hidden.push_back({EffectId::kRotorInertia, j, {0.1}});
  }
  Experiment e = make_simulated_experiment(name, kYawArm, {"yaw", "shoulder", "elbow"}, hidden);
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) {
    for (size_t j = 0; j < r.joints.size(); ++j) {
      const std::vector<double>&q = r.joints[j].signal[0], &v = r.joints[j].signal[1];
      std::vector<double>& effort = r.joints[j].signal[2];
      for (size_t k = 0; k < r.size(); ++k)
        effort[k] = (effort[k] + (j == kYaw ? hides : blurs) * std::sin(40.0 * q[k]) * std::tanh(v[k] / 0.05)) / 8.0;
    }
  }
  return e;
}

TEST(EffortUnits, AJointWhoseMotionHardlyTellsItTakesTheUnitOfItsNeighbours) {
  const Experiment e = make_yaw_currents("units_yaw", 1.0, 0.0);
  const std::vector<EffortUnit> units = find_units(e);
  ASSERT_EQ(units.size(), 3u);
  const auto is_yaw = [](const EffortUnit& u) { return u.joint == kYaw; };
  const EffortUnit yaw = *std::find_if(units.begin(), units.end(), is_yaw);
  for (const EffortUnit& u : units) {
    EXPECT_NEAR(u.scale, 8.0, 0.8) << u.joint;  // a tenth, as above
    EXPECT_EQ(u.by_others, is_yaw(u)) << u.joint;
    // It is no better known than theirs: an arm's shoulder took 8.24 +- 0.48 N m a unit from 7.7 and 8.9 of its neighbours.
    EXPECT_LE(yaw.low, u.scale) << u.joint;
    EXPECT_GE(yaw.high, u.scale) << u.joint;
  }
}

// An arm of hobby servos logged counts. One joint told their unit to a fifth; of the others, weight in counts was called a
// constant torque of 18 N m.
TEST(EffortUnits, WhereNoneIsToldSharplyTheOthersTakeAWideOne) {
  const std::vector<EffortUnit> units = find_units(make_yaw_currents("units_wide", 4.0, 2.5));
  ASSERT_EQ(units.size(), 3u);
  for (const EffortUnit& u : units) {
    EXPECT_GT(u.high / u.low, 1.35) << u.joint;  // none is sharp: 0.3 of a logarithm (shares.h)
    if (u.joint != kYaw) continue;
    EXPECT_TRUE(u.by_others);
    EXPECT_LT(u.low, 8.0);
    EXPECT_GT(u.high, 8.0);
  }
}

TEST(EffortUnits, AJointWithoutADriveHasNoEffortInAnyUnit) {
  Experiment e = simulate_currents("units_passive", make_arm_drives(), {8.0, 8.0});
  for (LinkSpec& link : e.robot.tree.links) link.joint.actuated = link.joint.actuated && link.joint.name != "elbow";
  const std::vector<EffortUnit> units = find_units(e);
  ASSERT_EQ(units.size(), 1u);
  EXPECT_EQ(e.robot.tree.joint(units[0].joint).name, "shoulder");
}

TEST(EffortUnits, EffortsInNewtonMetresHaveNoUnitToFind) {
  EXPECT_TRUE(find_units(simulate_currents("units_torque", make_arm_drives(), {1.0, 1.0})).empty());
}

TEST(EffortUnits, AGainOfOneHalfIsAWrongTorqueConstantAndNoUnit) {
  EXPECT_TRUE(find_units(simulate_currents("units_gain", make_arm_drives(), {2.0, 2.0})).empty());
}

// Two kilograms in the hand: the elbow's torques are five times those of the model, the shoulder's three times.
TEST(EffortUnits, AHeavyLoadIsNoUnit) {
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kPayload, kFore, {2.0, 0.3, 0.0, 0.0, 0.0}});
  EXPECT_TRUE(find_units(simulate_currents("units_load", hidden, {1.0, 1.0})).empty());
}

// Three to four amperes for a newton metre. A load that asks for so much would be heavier than the arm.
TEST(EffortUnits, AmperesBelowAFactorOfTenAreAUnitWhereNoLoadDoesAsWell) {
  const std::vector<double> torque_of_unit{0.25, 0.32};
  const std::vector<EffortUnit> units = find_units(simulate_currents("units_amperes4", make_arm_drives(), torque_of_unit));
  ASSERT_EQ(units.size(), 2u);
  for (const EffortUnit& u : units) EXPECT_NEAR(u.scale / torque_of_unit[static_cast<size_t>(u.joint)], 1.0, 0.1) << u.joint;  // a tenth, as above
}

// Twenty newton metres to an ampere at the elbow, and nearly one at the shoulder: the log is one of currents. Friction of the
// shoulder was supported as if in N m before.
TEST(EffortUnits, AUnitNearOneIsAUnitBesideOneThatNoModelExplains) {
  const std::vector<double> torque_of_unit{0.6, 20.0};
  const std::vector<EffortUnit> units = find_units(simulate_currents("units_near_one", make_arm_drives(), torque_of_unit));
  ASSERT_EQ(units.size(), 2u);
  for (const EffortUnit& u : units) EXPECT_NEAR(u.scale / torque_of_unit[static_cast<size_t>(u.joint)], 1.0, 0.1) << u.joint;  // a tenth, as above
}

// A joint without a motor takes no unit from its neighbours.
TEST(EffortUnits, AJointWithoutADriveHasNoUnit) {
  Experiment e = simulate_currents("units_passive", make_arm_drives(), {8.0, 1.0});
  e.robot.tree.links[static_cast<size_t>(kFore)].joint.actuated = false;
  for (const EffortUnit& u : find_units(e)) EXPECT_EQ(u.joint, kShoulder);
}

TEST(EffortUnits, ACountOfOneTenthAtBothJointsIsAUnit) {
  EXPECT_EQ(find_units(simulate_currents("units_count", make_arm_drives(), {0.1, 0.1})).size(), 2u);
}

// A rotor adds to the disc's inertia and never takes from it: volts that are far below the disc's own torque are no N m.
TEST(EffortUnits, EffortsBelowWhatTheBodiesAloneTakeAreAnotherUnitWhateverTheRotor) {
  Experiment e = simulate_heavy_disc("units_disc_volts");
  EXPECT_TRUE(find_units(e).empty());
  for (Recording& r : e.recordings) {
    for (double& y : r.joints[0].signal[2]) y /= 35.0;
  }
  const std::vector<EffortUnit> units = find_units(e);
  ASSERT_EQ(units.size(), 1u);
  EXPECT_NEAR(units[0].scale, 35.0, 3.5);  // a tenth, as above
}

// A second and a half at 100 Hz: few samples tell a unit that leaves hardly anything of the efforts.
TEST(EffortUnits, AShortLogTellsItsUnitIfThatExplainsTheEfforts) {
  Experiment e = simulate_currents("units_short", make_arm_drives(), {8.0, 8.0});
  e.recordings.resize(1);
  Recording& r = e.recordings[0];
  const auto end = std::upper_bound(r.time.begin(), r.time.end(), r.time.front() + 1.5);
  const auto size = static_cast<size_t>(end - r.time.begin());
  const auto cut = [&](std::vector<double>& column) { column.resize(std::min(column.size(), size)); };
  cut(r.time);
  for (JointColumns& joint : r.joints) {
    cut(joint.command), cut(joint.command_rate);
    for (std::vector<double>& column : joint.signal) cut(column);
  }
  for (const EffortUnit& u : find_units(e)) EXPECT_NEAR(u.scale, 8.0, 0.8) << u.joint;  // a tenth, as above
  EXPECT_EQ(find_units(e).size(), 2u);
}

// Hardly any friction tells which way the drive acts. No load turns the torque of all motions into minus eight times.
TEST(EffortUnits, ATurnedCurrentThatNoLoadExplainsIsFound) {
  const std::vector<EffortUnit> units = find_units(simulate_currents("units_turned_amperes", {}, {1.0, -0.125}));
  ASSERT_EQ(units.size(), 1u);
  EXPECT_LT(units[0].scale, 0.0);
}

TEST(EffortUnits, AnEffortWithItsSignTurnedIsRefusedWithItsColumn) {
  const Experiment e = simulate_currents("units_turned", make_arm_drives(), {1.0, -1.0});
  try {
    find_conventions(e, 1);
    FAIL() << "the turned sign was not seen";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("/joint_states/elbow/effort"), std::string::npos) << error.what();
  }
}

// Position logs of a servo whose gains somebody read off a data sheet in other units.
// Half a metre behind the elbow, 2 kg turn the torque of gravity there.
TEST(EffortUnits, ALoadOnTheFarSideOfAJointTurnsNoSign) {
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kPayload, kFore, {2.0, -0.5, 0.0, 0.0, 0.0}});
  EXPECT_TRUE(find_units(simulate_currents("units_far", hidden, {1.0, 1.0})).empty());
  EXPECT_TRUE(find_units(simulate_currents("units_far_frictionless", {hidden.back()}, {1.0, 1.0})).empty());
}

// The last link of an industrial arm weighs nothing beside its drive's friction, which varies with the position.
TEST(EffortUnits, FrictionThatResemblesTheTorqueOfALightWristTurnsNoSign) {
  std::string arm = kArm;
  const std::string fore = R"(<mass value="1"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
  <joint)";
  const size_t at = arm.find(fore);
  ASSERT_NE(at, std::string::npos);
  arm.replace(at, fore.size(), R"(<mass value="1e-4"/>
    <inertia ixx="1e-8" ixy="0" ixz="0" iyy="1e-8" iyz="0" izz="1e-8"/></inertial></link>
  <joint)");
  Experiment e = make_simulated_experiment("units_wrist", arm, kArmJoints, make_arm_drives());
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) {
    const std::vector<double>&shoulder = r.joints[kShoulder].signal[0], &elbow = r.joints[kElbow].signal[0], &v = r.joints[kElbow].signal[1];
    for (size_t k = 0; k < r.size(); ++k)
      r.joints[kElbow].signal[2][k] += 0.4 * std::sin(9.0 * elbow[k]) * std::tanh(v[k] / 0.05) + std::cos(shoulder[k] + elbow[k]);
  }
  EXPECT_TRUE(find_units(e).empty());
}

// Servos with stated gains whose log holds currents: it does not follow the servo's law in N m.
TEST(EffortUnits, CurrentsOfServosAreToldLikeThoseOfOtherDrives) {
  Experiment e = simulate_currents("units_servo", make_arm_drives(), {8.0, 5.0});
  e.scenario.drive = "servo";
  const std::vector<EffortUnit> units = find_units(e);
  ASSERT_EQ(units.size(), 2u);
  // 1 %: noise of the encoders in the servo's law.
  for (const EffortUnit& u : units) EXPECT_NEAR(u.scale, u.joint == kShoulder ? 8.0 : 5.0, u.joint == kShoulder ? 0.08 : 0.05);
}

TEST(EffortUnits, GainsInAnotherUnitAreToldWithoutLoggedEfforts) {
  Experiment e = simulate_arm("units_gains", make_arm_drives());
  EXPECT_TRUE(find_units(e).empty());
  e.scenario.servo_default.kp *= 0.1, e.scenario.servo_default.kd *= 0.1;
  for (Recording& r : e.recordings) {
    for (JointColumns& joint : r.joints) joint.signal[2].clear();
  }
  const std::vector<EffortUnit> units = find_units(e);
  ASSERT_EQ(units.size(), 2u);
  for (const EffortUnit& u : units) {
    EXPECT_TRUE(u.of_gains);
    EXPECT_NEAR(u.scale, 10.0, 1.0);  // a tenth, as for currents
  }
}

// A motor that turns a disc against friction, logged in hundredths: nothing tells that they are no N m.
TEST(EffortUnits, WhatIsFoundWhereTheUnitIsNotToldIsInTheUnitOfTheLog) {
  Experiment e = make_simulated_experiment("units_untold", kDisc, {"motor"}, {{EffectId::kCoulomb, 0, {1.0, 0.0, 5e-4}}, {EffectId::kRotorInertia, 0, {0.1}}});
  e.scenario.drive = "effort";
  const Json report = diagnose_recordings(e, {}, [](const std::string&) {}, [](const Reports&) {}).report;
  ASSERT_FALSE(report["findings"].empty());
  EXPECT_EQ(report["untold_units"], Json({"motor"}));
  EXPECT_NE(report["warnings"].dump().find("/joint_states/motor/effort: this motion does not tell its unit"), std::string::npos);
  EXPECT_NE(report["summary"].get<std::string>().find("the unit of the effort of motor"), std::string::npos) << report["summary"];
  for (const Json& f : report["findings"]) EXPECT_TRUE(f.contains("in_log_unit")) << f["statement"];
}

// A heavy disc with the current of its motor as effort: it takes a fortieth of what is logged, as a rotor of 39 discs would.
TEST(EffortUnits, ARotorThatTheUnitMayBeIsNotSure) {
  Experiment e = simulate_heavy_disc("units_rotor");
  for (Recording& r : e.recordings) {
    for (double& y : r.joints[0].signal[2]) y *= 40.0;
  }
  Reports reports;
  reports.report["findings"] = {{{"effect", "rotor_inertia"}, {"where", {{"joint", "motor"}}}, {"grade", "supported"}, {"statement", ""},
                                 {"alternatives", Json::array()}, {"parameters", {{"inertia", {{"value", 7.8}, {"unit", "kg m^2"}}}}}}};
  doubt_untold_units(e, list_untold_units(make_torque_data(e), {}), &reports);
  const Json& rotor = reports.report["findings"][0];
  EXPECT_EQ(rotor["grade"], "ambiguous");
  ASSERT_EQ(rotor["alternatives"].size(), 1u);
  EXPECT_NEAR(rotor["alternatives"][0]["parameters"]["scale"]["value"].get<double>(), 1.0 / 40.0, 0.1 / 40.0);  // a tenth, as above
}

// A motor at full duty, 100 in either direction, of 0.003 N m each, against viscous friction (back-EMF) of 0.02 N m s/rad.
// Dry friction of 99.7 N m beside efforts in N m would make the same step.
Experiment make_steps(const std::string& name) {
  Experiment e = make_simulated_experiment(name, kDisc, {"motor"}, {});
  e.scenario.drive = "effort";
  TestNoise noise;
  for (size_t i = 0; i < e.recordings.size(); ++i) {
    Recording& r = e.recordings[i];
    const double sign = i == 1 ? -1.0 : 1.0, speed = 100.0 * 0.003 / 0.02, settles = 0.002 / 0.02;  // [rad/s], [s]
    for (size_t k = 0; k < r.size(); ++k) {
      const double t = r.time[k] - r.time[0], decay = std::exp(-t / settles);
      r.joints[0].signal[0][k] = sign * speed * (t - settles * (1.0 - decay)) + 1e-4 * noise.draw();
      r.joints[0].signal[1][k] = sign * speed * (1.0 - decay) + 1e-2 * noise.draw();
      r.joints[0].signal[2][k] = sign * 100.0;
    }
  }
  return e;
}

Reports make_level_report(double level) {
  Reports reports;
  reports.report["findings"] = {{{"effect", "coulomb_friction"}, {"where", {{"joint", "motor"}}}, {"grade", "supported"}, {"statement", ""},
                                 {"alternatives", Json::array()}, {"parameters", {{"level", {{"value", level}, {"unit", "N m"}}}}}}};
  return reports;
}

TEST(EffortUnits, FrictionThatTakesAConstantEffortMayBeItsUnit) {
  const Experiment e = make_steps("units_steps");
  Reports reports = make_level_report(99.7);
  doubt_untold_units(e, list_untold_units(make_torque_data(e), {}), &reports);
  const Json& friction = reports.report["findings"][0];
  EXPECT_EQ(friction["grade"], "ambiguous");
  ASSERT_EQ(friction["alternatives"].size(), 1u);
  EXPECT_NEAR(friction["alternatives"][0]["parameters"]["scale"].get<double>(), 0.003, 0.0003);  // a tenth, as above
}

TEST(EffortUnits, AConstantEffortThatTheMotionOpposesMayHaveItsSignTurned) {
  Experiment e = make_steps("units_opposed");
  for (Recording& r : e.recordings) {
    for (double& y : r.joints[0].signal[2]) y = -y;
  }
  const std::optional<double> unit = find_unit_without_friction(make_torque_data(e), 0);
  ASSERT_TRUE(unit.has_value());
  EXPECT_NEAR(*unit, -0.003, 0.0003);
}

// A winch that lifts 0.5 kg, with currents of 7.2 N each: the weight is as constant as a constant force is.
TEST(EffortUnits, AConstantForceBesideAConstantWeightMayBeTheUnit) {
  std::string lift = kDisc;
  lift.replace(lift.find("revolute"), 8, "prismatic");
  lift.replace(lift.find("mass value=\"0.1\""), 16, "mass value=\"0.5\"");
  Experiment e = make_simulated_experiment("units_lift", lift, {"motor"}, {{EffectId::kCoulomb, 0, {1.5, 0.0, 5e-4}}});
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) {
    for (double& y : r.joints[0].signal[2]) y /= 7.2;
  }
  const std::optional<double> unit = find_unit_without_constant(make_torque_data(e), 0);
  ASSERT_TRUE(unit.has_value());
  EXPECT_NEAR(*unit, 7.2, 0.4);
  EffortUnit untold;  // where a current is too noisy to show what the load's acceleration takes
  untold.joint = 0, untold.without_constant = *unit;
  Reports reports;
  reports.report["findings"] = {{{"effect", "constant_torque"}, {"where", {{"joint", "motor"}}}, {"grade", "supported"}, {"statement", ""},
                                 {"alternatives", Json::array()}, {"parameters", {{"torque", {{"value", -4.2}, {"unit", "N"}}}}}}};
  doubt_untold_units(e, {untold}, &reports);
  EXPECT_EQ(reports.report["findings"][0]["grade"], "ambiguous");
  EXPECT_EQ(reports.report["findings"][0]["alternatives"].size(), 1u);
}

// Friction that turns with the motion is there in any unit.
TEST(EffortUnits, FrictionOfAMotionBackAndForthIsNoUnit) {
  Experiment e = make_simulated_experiment("units_back", kDisc, {"motor"}, {{EffectId::kCoulomb, 0, {1.0, 0.0, 5e-4}}, {EffectId::kRotorInertia, 0, {0.1}}});
  e.scenario.drive = "effort";
  EXPECT_FALSE(find_unit_without_friction(make_torque_data(e), 0).has_value());
}

// What no effect explains is told in the unit of the log, too.
TEST(EffortUnits, WhatIsMissingBesideAnUntoldUnitIsNotInNewtonMetres) {
  const Experiment e = simulate_heavy_disc("units_missing");
  Reports reports;
  reports.report["findings"] = Json::array();
  reports.report["unexplained"] = {{{"where", {{"joint", "motor"}}}, {"statement", "motor: about 110 N m (root mean square) are missing"}}};
  EffortUnit untold;
  untold.joint = 0;
  doubt_untold_units(e, {untold}, &reports);
  EXPECT_EQ(reports.report["unexplained"][0]["statement"], "motor: about 110 in the unit of the log (root mean square) are missing");
}

TEST(EffortUnits, OfAnArmWhoseLoadsTellItNoUnitIsDoubted) {
  Experiment e = simulate_arm("units_sure", make_arm_drives());
  e.scenario.drive = "effort";
  EXPECT_TRUE(find_conventions(e, 1).untold.empty());
}

TEST(EffortUnits, FrictionIsReportedInNewtonMetresBesideTheUnit) {
  const Experiment e = simulate_currents("units_report", make_arm_drives(), {8.0, 8.0});
  const Reports reports = diagnose_recordings(e, {}, [](const std::string&) {}, [](const Reports&) {});
  bool unit = false, friction = false;
  for (const Json& f : reports.report["findings"]) {
    unit = unit || (f["effect"] == "torque_constant_error" && f["where"]["joint"] == "shoulder");
    if (f["family"] != "dry friction" || f["where"]["joint"] != "shoulder" || !f["parameters"].contains("level")) continue;
    friction = true;
    // 15 %: as far as the unit's bracket reaches.
    EXPECT_NEAR(f["parameters"]["level"]["value"].get<double>(), 1.5, 0.15 * 1.5);
  }
  EXPECT_TRUE(unit);
  EXPECT_TRUE(friction) << reports.report["findings"].dump(1);
}

// Twice the same recordings: long enough for a first answer.
TEST(EffortUnits, TheFirstAnswerHasThemToo) {
  Experiment e = simulate_currents("units_first", make_arm_drives(), {8.0, 8.0});
  const std::vector<Recording> once = e.recordings;
  for (Recording r : once) {
    r.spec.name = "again_" + r.spec.name;
    e.recordings.push_back(std::move(r));
  }
  // The search behind it takes half a minute: the test ends with the first answer.
  struct Enough { Json report; };
  Json first;
  try {
    diagnose_recordings(e, {}, [](const std::string&) {}, [](const Reports& reports) { throw Enough{reports.report}; });
  } catch (const Enough& enough) {
    first = enough.report;
  }
  ASSERT_TRUE(first.is_object());
  EXPECT_TRUE(first["preliminary"].get<bool>());
  bool unit = false;
  for (const Json& f : first["findings"]) unit = unit || (f["effect"] == "torque_constant_error" && f["where"]["joint"] == "shoulder");
  EXPECT_TRUE(unit) << first["findings"].dump(1);
}

}  // namespace
}  // namespace hrp::diagnosis
