// SPDX-License-Identifier: BSD-3-Clause
// Logged efforts that are currents: the torque of one logged unit is found beside friction and rotors, joint by joint,
// and what is merely a wrong gain or a heavy load is no unit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/diagnostics.h"
#include "diagnosis/conventions/effort_units.h"
#include "diagnosis/conventions/log_conventions.h"
#include "diagnosis/conventions/unit_doubts.h"
#include "diagnosis/diagnose_recordings.h"
#include "tests/unit/diagnosis/heavy_disc.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

std::vector<EffortUnit> find_units(const Experiment& e) { return find_effort_units(make_torque_data(e)); }

TEST(EffortUnits, CurrentsOfDrivesWithFrictionAndRotorsAreToldWithTheirTorqueConstants) {
  const std::vector<double> torque_of_unit{8.0, 5.0};
  const std::vector<EffortUnit> units =
      find_units(simulate_currents("units_amperes", make_arm_drives(), torque_of_unit));
  ASSERT_EQ(units.size(), 2u);
  for (const EffortUnit& u : units) {
    // A tenth: the two regressions are biased by what dry friction leaves near rest.
    EXPECT_NEAR(u.scale, torque_of_unit[static_cast<size_t>(u.joint)],
                0.1 * torque_of_unit[static_cast<size_t>(u.joint)]);
    EXPECT_LE(u.low, u.scale);
    EXPECT_GE(u.high, u.scale);
  }
}

TEST(EffortUnits, OfAMotorWithoutALoadTheUnitCannotBeChecked) {
  Experiment e = make_simulated_experiment(
      "units_disc", kDisc, {"motor"}, {{EffectId::kCoulomb, 0, {1.0, 0.0, 5e-4}}, {EffectId::kRotorInertia, 0, {0.1}}});
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

// Its currents of 8 N m. Friction over position, in no list, of `hides` N m hides the torque that the yaw joint's
// motion takes, and of `blurs` that of the others.
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
    // It is no better known than theirs: an arm's shoulder took 8.24 +- 0.48 N m a unit from 7.7 and 8.9 of its
    // neighbours.
    EXPECT_LE(yaw.low, u.scale) << u.joint;
    EXPECT_GE(yaw.high, u.scale) << u.joint;
  }
}

// An arm of hobby servos logged counts. One joint told their unit to a fifth; of the others, weight in counts was
// called a constant torque of 18 N m.
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
  const std::vector<EffortUnit> units =
      find_units(simulate_currents("units_amperes4", make_arm_drives(), torque_of_unit));
  ASSERT_EQ(units.size(), 2u);
  for (const EffortUnit& u : units)
    EXPECT_NEAR(u.scale / torque_of_unit[static_cast<size_t>(u.joint)], 1.0, 0.1) << u.joint;  // a tenth, as above
}

// Twenty newton metres to an ampere at the elbow, and nearly one at the shoulder: the log is one of currents. Friction
// of the shoulder was supported as if in N m before.
TEST(EffortUnits, AUnitNearOneIsAUnitBesideOneThatNoModelExplains) {
  const std::vector<double> torque_of_unit{0.6, 20.0};
  const std::vector<EffortUnit> units =
      find_units(simulate_currents("units_near_one", make_arm_drives(), torque_of_unit));
  ASSERT_EQ(units.size(), 2u);
  for (const EffortUnit& u : units)
    EXPECT_NEAR(u.scale / torque_of_unit[static_cast<size_t>(u.joint)], 1.0, 0.1) << u.joint;  // a tenth, as above
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

// A rotor adds to the disc's inertia and never takes from it: volts that are far below the disc's own torque are no N
// m.
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
    cut(joint.command);
    cut(joint.command_rate);
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

TEST(EffortUnits, ACurrentWithItsSignTurnedHasTheUnitOfTheOthers) {
  const LogConventions found = find_conventions(simulate_currents("units_turned", make_arm_drives(), {8.0, -8.0}), 1);
  ASSERT_EQ(found.signs.size(), 1u);
  EXPECT_EQ(found.signs[0].joint, kElbow);
  ASSERT_EQ(found.units.size(), 2u);
  for (const EffortUnit& u : found.units) EXPECT_NEAR(u.scale, 8.0, 0.8) << u.joint;  // a tenth, as above
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
    const std::vector<double>&shoulder = r.joints[kShoulder].signal[0], &elbow = r.joints[kElbow].signal[0],
          &v = r.joints[kElbow].signal[1];
    for (size_t k = 0; k < r.size(); ++k)
      r.joints[kElbow].signal[2][k] +=
          0.4 * std::sin(9.0 * elbow[k]) * std::tanh(v[k] / 0.05) + std::cos(shoulder[k] + elbow[k]);
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
  for (const EffortUnit& u : units)
    EXPECT_NEAR(u.scale, u.joint == kShoulder ? 8.0 : 5.0, u.joint == kShoulder ? 0.08 : 0.05);
}

TEST(EffortUnits, GainsInAnotherUnitAreToldWithoutLoggedEfforts) {
  Experiment e = simulate_arm("units_gains", make_arm_drives());
  EXPECT_TRUE(find_units(e).empty());
  e.scenario.servo_default.kp *= 0.1;
  e.scenario.servo_default.kd *= 0.1;
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

}  // namespace
}  // namespace hrp::diagnosis
