// SPDX-License-Identifier: BSD-3-Clause
// Drives that give less torque than they log: the limit, or the dead zone, is told from friction, rotors, loads and
// gains.
#include <gtest/gtest.h>

#include "diagnosis/measurement/effort_limits.h"
#include "tests/unit/diagnosis/torque_verdicts.h"

namespace hrp::diagnosis {
namespace {

constexpr double kLimit = 9.0;  // [N m], half of what the shoulder needs

// The log is the torque that the servo asks for.
Experiment make_limited(const std::string& name, Hypothesis hidden) {
  hidden.push_back({EffectId::kSaturation, kShoulder, {kLimit}});
  Experiment e = simulate_arm(name, hidden);
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) forget_commands(&r);
  return e;
}

// A rotor many times too large stood for it before, or nothing was found at this joint.
TEST(EffortLimits, TorqueThatIsLoggedBeyondTheLimitOfTheDriveIsSaidAndNoRotorStandsForIt) {
  const TorqueVerdict verdict = judge_torque(make_limited("limits", make_arm_drives()), 1);
  const Finding* f = find(verdict, "torque_saturation", "shoulder");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->grade, Grade::kSupported) << f->statement;
  EXPECT_NEAR(f->parameters[0].value[0], kLimit, 0.05 * kLimit) << f->statement;  // the filter rounds the corners
  const Finding* rotor = find(verdict, "rotor_inertia", "shoulder");
  if (rotor && rotor->grade == Grade::kSupported) {
    EXPECT_NEAR(rotor->parameters[0].value[0], 0.6, 3.0 * rotor->parameters[0].std[0]) << rotor->statement;
  }
}

TEST(EffortLimits, DrivesThatGiveWhatTheyLogHaveNone) {
  Experiment e = simulate_arm("limits_none", make_arm_drives());
  e.scenario.drive = "effort";
  for (int joint : {kShoulder, kElbow}) EXPECT_TRUE(find_limits(make_torque_data(e), joint).empty());
  Hypothesis loaded = make_arm_drives();
  loaded.push_back({EffectId::kPayload, kFore, {1.0, 0.3, 0.0, 0.0, 0.0}});
  loaded.push_back({EffectId::kLoadFriction, kShoulder, {0.2}});
  e = simulate_arm("limits_loaded", loaded);
  e.scenario.drive = "effort";
  for (int joint : {kShoulder, kElbow}) EXPECT_TRUE(find_limits(make_torque_data(e), joint).empty());
}

// Friction between 4 and 6 N m takes all of the effort. A limit of 4 N m beside friction of 4 N m would explain it as
// well, but nothing would then move the joint.
TEST(EffortLimits, ADriveThatGivesNoMoreThanItsFrictionWouldNotMove) {
  const Experiment e = make_limited("limits_stuck", make_arm_drives());
  TorqueData data = make_torque_data(e);
  for (TorqueRecording& r : data.recordings) {
    const Eigen::ArrayXd time =
        Eigen::ArrayXd::LinSpaced(r.effort.rows(), 0.0, r.step * static_cast<double>(r.effort.rows() - 1));
    r.effort.col(kElbow) = data.calc_sign(r, kElbow).array() * (4.0 + 2.0 * (3.0 * time).sin().abs());
    r.tau.col(kElbow).setZero();
  }
  EXPECT_TRUE(find_limits(data, kElbow).empty());
}

// The elbow's drive does nothing for the smallest quarter of what its servo asks for.
constexpr double kWidth = 1.2;  // [N m]

Experiment make_dead(const std::string& name) {
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({find_effect("dead_zone")->id, kElbow, {kWidth}});
  Experiment e = simulate_arm(name, hidden);
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) forget_commands(&r);
  return e;
}

TEST(DeadZones, EffortsBelowAWidthThatGiveNothingAreToldFromDryFriction) {
  const TorqueVerdict verdict = judge_torque(make_dead("dead_zones"), 1);
  const Finding* f = find(verdict, "dead_zone", "elbow");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->grade, Grade::kSupported) << f->statement;
  EXPECT_NEAR(f->parameters[0].value[0], kWidth, 0.05 * kWidth) << f->statement;  // the filter rounds the corners
  const Finding* friction = find(verdict, "coulomb_friction", "elbow");
  ASSERT_NE(friction, nullptr);
  EXPECT_NEAR(friction->parameters[0].value[0], 0.8, 3.0 * friction->parameters[0].std[0]) << friction->statement;
}

// A motor's duty: without the zone, its unit was a fifth too small.
TEST(DeadZones, OfADriveThatLogsItsDutyLeaveTheUnitAsItIs) {
  constexpr double kUnit = 0.05;  // [N m] per logged unit
  Experiment e = make_dead("dead_zones_duty");
  for (Recording& r : e.recordings) {
    for (double& y : r.joints[kElbow].signal[static_cast<int>(Quantity::kEffort)]) y /= kUnit;
  }
  const std::optional<double> unit = find_unit_beside_dead_zone(collect_efforts(make_torque_data(e), kElbow));
  ASSERT_TRUE(unit);
  EXPECT_NEAR(*unit, kUnit, 0.1 * kUnit);  // the filter rounds the corners
}

// On a real leg that hung, slow calves followed their efforts within dry friction: dead zones of its size stood for it.
TEST(DeadZones, AreNotToldFromFrictionWhileTheDriveLeadsAllTheTime) {
  const long count = 2000;
  UnitRows rows;
  rows.effort = Eigen::ArrayXd::LinSpaced(count, 0.0, 60.0).sin() * 2.0;
  rows.tau = rows.effort - rows.effort.cwiseMax(-0.5).cwiseMin(0.5);
  rows.nuisance = Eigen::MatrixXd::Random(count, kNuisance);  // v, direction, a, 1
  rows.nuisance.rightCols(1).setOnes();
  rows.nuisance.col(1) = rows.effort.cwiseSign();
  EXPECT_FALSE(find_unit_beside_dead_zone(rows));
  for (long i = 0; i < count; i += 3) rows.nuisance(i, 1) *= -1.0;  // it brakes
  const std::optional<double> unit = find_unit_beside_dead_zone(rows);
  ASSERT_TRUE(unit);
  EXPECT_NEAR(*unit, 1.0, 0.01);
}

TEST(DeadZones, DrivesWithFrictionAloneHaveNone) {
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kLoadFriction, kShoulder, {0.2}});
  hidden.push_back({EffectId::kStribeck, kElbow, {0.5, 1.0, 0.1, 0.0, 5e-4}});
  Experiment e = simulate_arm("dead_zones_none", hidden);
  e.scenario.drive = "effort";
  const TorqueData data = make_torque_data(e);
  for (int joint : {kShoulder, kElbow}) {
    EXPECT_TRUE(find_dead_zones(data, joint).empty());
    EXPECT_FALSE(find_unit_beside_dead_zone(collect_efforts(data, joint)));
  }
}

}  // namespace
}  // namespace hrp::diagnosis
