// SPDX-License-Identifier: BSD-3-Clause
// What logs do to the torque stage: short, late, frozen or incomplete ones, and ones without gravity.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>

#include "diagnosis/measurement/torque/effort.h"
#include "diagnosis/measurement/torque/flags.h"
#include "diagnosis/simulation/bodies.h"
#include "tests/test_places.h"
#include "tests/unit/diagnosis/torque_verdicts.h"

namespace hrp::diagnosis {
namespace {

// The first `seconds` of a recording.
Recording take(const Recording& whole, double seconds) {
  Recording r = whole;
  const auto rows = static_cast<size_t>(
      std::count_if(r.time.begin(), r.time.end(), [&](double t) { return t - r.time[0] < seconds; }));
  r.time.resize(rows);
  for (JointColumns& joint : r.joints) {
    for (std::vector<double>* column :
         {&joint.command, &joint.command_rate, &joint.signal[0], &joint.signal[1], &joint.signal[2]})
      column->resize(std::min(column->size(), rows));
  }
  return r;
}

// Five stretches of two seconds in all, one of which has all that the elbow tells: its own parts are one more.
TEST(TorqueLog, FrictionOfAJointThatMovesInOneShortRecordingIsFound) {
  Experiment e = make_simulated_experiment("torque_short", kArm, kArmJoints, make_arm_drives());
  const Recording all = e.recordings[0];
  e.recordings = {take(all, 5.2), take(all, 5.2), take(all, 2.4)};
  for (size_t r : {0u, 1u}) {
    JointColumns& elbow = e.recordings[r].joints[kElbow];
    std::fill(elbow.signal[0].begin(), elbow.signal[0].end(), elbow.signal[0][0]);
    std::fill(elbow.signal[1].begin(), elbow.signal[1].end(), 0.0);
  }
  const TorqueVerdict verdict = judge_torque(e, 1);
  EXPECT_TRUE(find(verdict, "coulomb_friction", "elbow") || find(verdict, "viscous_friction", "elbow"));
}

// A second without samples is no straight motion: friction is that of the whole recording.
TEST(TorqueLog, AGapInALogTellsNothingAndChangesNoFriction) {
  const Hypothesis hidden = make_arm_drives();
  Experiment e = make_simulated_experiment("torque_gap", kArm, kArmJoints, hidden);
  for (Recording& r : e.recordings) {
    const auto drop = [&](std::vector<double>* column) {
      if (column->size() == 1200) column->erase(column->begin() + 400, column->begin() + 600);
    };
    drop(&r.time);
    for (JointColumns& joint : r.joints) {
      for (std::vector<double>* column :
           {&joint.command, &joint.command_rate, &joint.signal[0], &joint.signal[1], &joint.signal[2]})
        drop(column);
    }
    ASSERT_EQ(r.time.size(), 1000u);
  }
  expect_drives(judge_torque(e, 1), hidden);
}

// An effort that swings between its limits jumps by more within a sample than friction is: it tells nothing beside a
// calm stretch.
TEST(TorqueLog, AServoThatSwingsBetweenItsLimitsChangesNoFriction) {
  const Hypothesis hidden = make_arm_drives();
  Experiment e = make_simulated_experiment("torque_limits", kArm, kArmJoints, hidden);
  for (size_t k = 300; k < 900; ++k) e.recordings[0].joints[kElbow].signal[2][k] = k / 3 % 2 ? 50.0 : -50.0;
  expect_drives(judge_torque(e, 1), hidden);
}

// Real efforts as a controller would log them that compensates gravity elsewhere. The single pendulum hangs still at
// first and swings in the held-out part: what swings is no outlier.
TEST(TorqueLog, OfRealPendulumsWhoseLogsLeaveGravityOutGravityIsNamed) {
  for (const char* name : {"dfki_simple_pendulum", "dfki_double_pendulum"}) {
    const std::filesystem::path path =
        std::filesystem::path(source_dir()) / "../shared/recordings" / name / "experiment.yaml";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
    Experiment e = load_experiment(path.string());
    const Plant plant = make_plant(e, {});
    for (Recording& r : e.recordings) {
      Eigen::MatrixXd q(static_cast<long>(r.time.size()), e.num_joints());
      for (long j = 0; j < q.cols(); ++j)
        q.col(j) = Eigen::Map<const Eigen::VectorXd>(r.joints[static_cast<size_t>(j)].signal[0].data(), q.rows());
      const Eigen::MatrixXd rest = Eigen::MatrixXd::Zero(q.rows(), q.cols()),
                            gravity = calc_efforts(plant, q, rest, rest);
      for (long j = 0; j < q.cols(); ++j) {
        for (long k = 0; k < q.rows(); ++k)
          r.joints[static_cast<size_t>(j)].signal[2][static_cast<size_t>(k)] -= gravity(k, j);
      }
    }
    const TorqueVerdict verdict = judge_torque(e, 1);
    const Finding* carried = find(verdict, "gravity_compensation", "base_link");
    ASSERT_NE(carried, nullptr) << name;
    // The torque constant of the single pendulum's drive is off by 11 %, by the notes beside its recordings 10 to 25 %.
    EXPECT_NEAR(carried->parameters[0].value[0], 1.0, 0.2) << carried->statement;
  }
}

TEST(TorqueLog, LateCommandsShowInTheServosOwnLawBesideFriction) {
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kDelay, kElbow, {0.012}});
  const TorqueVerdict verdict = judge_torque(make_simulated_experiment("torque_late", kArm, kArmJoints, hidden), 1);
  const Finding* f = find(verdict, "command_delay", "elbow");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(find(verdict, "command_delay", "shoulder"), nullptr);
  // A millisecond: a fifth of the recording's sample time, which the parabola through the scan resolves.
  EXPECT_NEAR(f->parameters[0].value[0], 0.012, 1e-3);
}

// Back-EMF of a motor at a voltage brakes as viscous friction kt^2/R does. Where supply, resistance and torque constant
// are stated it is in the model, and no finding: only what the gear adds is.
TEST(TorqueLog, BackEmfOfAStatedVoltageDriveIsNoFinding) {
  constexpr double kConstant = 2.0, kResistance = 5.0, kGear = 0.3;  // [N m/A], [ohm], [N m s/rad]
  Hypothesis hidden = make_arm_drives();
  hidden[3].p[0] = kConstant * kConstant / kResistance + kGear;  // at the elbow
  Experiment e = make_simulated_experiment("torque_voltage", kArm, kArmJoints, hidden);
  const Scenario stated = parse_scenario(
      "robot: robot.urdf\nbase: fixed\ndrive: voltage\nservo: {joints: {elbow: {kp: 500, kd: 25, supply: 125, "
      "resistance: 5, torque_constant: 2}}}\n",
      "voltage.yaml");
  ASSERT_EQ(stated.drive, "servo");
  EXPECT_DOUBLE_EQ(stated.servo_joints.at("elbow").kp, 200.0);  // what the recordings were made with
  EXPECT_DOUBLE_EQ(stated.servo_joints.at("elbow").effort_limit, 50.0);
  e.scenario.servo_joints = stated.servo_joints;
  e.scenario.joint_laws = stated.joint_laws;
  const TorqueVerdict verdict = judge_torque(e, 1);
  const Finding* f = find(verdict, "viscous_friction", "elbow");
  ASSERT_NE(f, nullptr);
  EXPECT_NEAR(f->parameters[0].value[0], kGear, 0.15 * kGear) << f->statement;  // as for all drives here
}

// A servo works with a velocity whether or not somebody recorded it.
TEST(TorqueLog, ABiasOfALogShowsInTheServosLawWithoutRecordedVelocities) {
  Experiment e = make_simulated_experiment("torque_bias", kArm, kArmJoints, make_arm_drives());
  for (Recording& r : e.recordings) {
    for (double& effort : r.joints[kElbow].signal[2]) effort += 0.7;
    for (JointColumns& joint : r.joints) joint.signal[1].clear();
  }
  const TorqueVerdict verdict = judge_torque(e, 1);
  const Finding* f = find(verdict, "sensor_bias", "/joint_states/elbow/effort");
  ASSERT_NE(f, nullptr);
  EXPECT_NEAR(f->parameters[0].value[0], 0.7, 0.02);  // three times what 0.02 N m of noise and a smoothed rate leave
  EXPECT_EQ(find(verdict, "constant_torque", "elbow"), nullptr);
}

// A bus or a filter brings efforts late: in fast motions that looks like friction, and hides the rotors.
TEST(TorqueLog, EffortsThatAreLoggedLateAreNoFriction) {
  const Hypothesis hidden = make_arm_drives();
  Experiment e = make_simulated_experiment("torque_late_log", kArm, kArmJoints, hidden);
  constexpr size_t kLate = 4;  // samples of 5 ms
  for (Recording& r : e.recordings) {
    for (JointColumns& joint : r.joints) {
      std::vector<double>& effort = joint.signal[2];
      std::rotate(effort.rbegin(), effort.rbegin() + kLate, effort.rend());
      std::fill(effort.begin(), effort.begin() + kLate, effort[kLate]);
    }
    forget_commands(&r);
  }
  const TorqueVerdict verdict = judge_torque(e, 1);
  expect_drives(verdict, hidden);
  for (const std::string& joint : kArmJoints) {
    const Finding* f = find(verdict, "sensor_delay", "/joint_states/" + joint + "/effort");
    ASSERT_NE(f, nullptr) << joint;
    // Slow friction hardly changes in 20 ms: the interval says how little the elbow tells, and is a third of its delay.
    EXPECT_NEAR(f->parameters[0].value[0], 0.02, 2.0 * f->parameters[0].std[0]) << f->statement;
    EXPECT_LT(f->parameters[0].std[0], 0.007) << f->statement;
  }
}

// A log of the efforts that drives were told. They take time to get there.
TEST(TorqueLog, EffortsThatDrivesGetLateAreADelayOfTheirCommands) {
  const Hypothesis hidden = make_arm_drives();
  Experiment e = make_simulated_experiment("torque_early_log", kArm, kArmJoints, hidden);
  e.scenario.drive = "effort";
  constexpr long kEarly = 4;  // samples of 5 ms
  for (Recording& r : e.recordings) {
    for (JointColumns& joint : r.joints) {
      std::vector<double>& effort = joint.signal[2];
      std::rotate(effort.begin(), effort.begin() + kEarly, effort.end());
      std::fill(effort.end() - kEarly, effort.end(), effort[effort.size() - kEarly - 1]);
    }
    forget_commands(&r);
  }
  const TorqueVerdict verdict = judge_torque(e, 1);
  expect_drives(verdict, hidden);
  const Finding* f = find(verdict, "command_delay", "shoulder");
  ASSERT_NE(f, nullptr);
  EXPECT_NEAR(f->parameters[0].value[0], 0.02, 2.0 * f->parameters[0].std[0]) << f->statement;
  EXPECT_LT(f->parameters[0].std[0], 0.007) << f->statement;  // as of a late log
  EXPECT_EQ(find(verdict, "actuator_lag", "shoulder"), nullptr);
}

// Back-EMF of a motor that is logged in volts: friction is nearly all of the effort, which therefore hardly follows the
// torque. Beside friction and rotor it does.
TEST(TorqueLog, AGainIsToldWhereFrictionIsMostOfTheEffort) {
  const Hypothesis hidden{{EffectId::kTorqueConstant, kShoulder, {0.55}},
                          {EffectId::kViscous, kShoulder, {40.0}},
                          {EffectId::kViscous, kElbow, {0.4}}};
  Experiment e = make_simulated_experiment("torque_volts", kArm, kArmJoints, hidden);
  for (Recording& r : e.recordings) forget_commands(&r);
  const TorqueVerdict verdict = judge_torque(e, 1);
  const Finding *gain = find(verdict, "torque_constant_error", "shoulder"),
                *viscous = find(verdict, "viscous_friction", "shoulder");
  ASSERT_NE(gain, nullptr);
  ASSERT_NE(viscous, nullptr);
  EXPECT_NEAR(gain->parameters[0].value[0], 0.55, 2.0 * gain->parameters[0].std[0]) << gain->statement;
  EXPECT_NEAR(viscous->parameters[0].value[0], 40.0, 2.0) << viscous->statement;  // without the gain 73
}

// Without efforts a delay T looks much like viscous friction kp T and a rotor kd T. What differs shows where the drive
// turns around, unless the joint sticks there: such stretches are left out.
TEST(TorqueLog, LateCommandsOfPositionLogsAreNoViscousFrictionAndNoRotor) {
  Hypothesis hidden{{EffectId::kCoulomb, kShoulder, {1.5, 0.0, 5e-4}}, {EffectId::kCoulomb, kElbow, {0.8, 0.0, 5e-4}}};
  for (int joint : {kShoulder, kElbow}) hidden.push_back({EffectId::kDelay, joint, {0.012}});
  Experiment e = make_simulated_experiment("torque_bus", kArm, kArmJoints, hidden);
  for (Recording& r : e.recordings) {
    for (JointColumns& joint : r.joints) joint.signal[2].clear();
  }
  const TorqueVerdict verdict = judge_torque(e, 1);
  for (const std::string& joint : kArmJoints) {
    const Finding* f = find(verdict, "command_delay", joint);
    ASSERT_NE(f, nullptr) << joint;
    EXPECT_NEAR(f->parameters[0].value[0], 0.012, 1e-3) << f->statement;  // a fifth of the sample time
    EXPECT_EQ(find(verdict, "viscous_friction", joint), nullptr);
    EXPECT_EQ(find(verdict, "rotor_inertia", joint), nullptr);
  }
}

// A quadruped hangs and swings its legs; a delay of all its commands is 8 ms +- 10 ms, in the place of twelve rotors.
// Its authors have a rotor in each joint. What the recordings do not tell from none takes the place of nothing.
void expect_rotors_of_the_quadruped(bool exchanged) {
  const std::filesystem::path path =
      std::filesystem::path(source_dir()) / "../shared/recordings/go2_hanging/experiment.yaml";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  Experiment e = load_experiment(path.string());
  for (Recording& r : e.recordings) r.spec.train = r.spec.train != exchanged;
  const TorqueVerdict verdict = judge_torque(e, 1);
  int rotors = 0;
  for (const Finding& f : verdict.evidence.findings) rotors += f.effect == "rotor_inertia" ? 1 : 0;
  EXPECT_GE(rotors, 7);  // more than half of twelve; with the delay in their place three
  for (const char* leg : {"FL", "FR", "RR"}) {
    const Finding* f = find(verdict, "rotor_inertia", leg + std::string("_calf_joint"));
    ASSERT_NE(f, nullptr) << leg;
    // 0.042 by the authors, 0.041 to 0.045 by least squares; friction and the delay move it by a fifth.
    EXPECT_NEAR(f->parameters[0].value[0], 0.042, 0.2 * 0.042) << f->statement;
  }
  for (const Finding& f : verdict.evidence.findings)
    EXPECT_FALSE(f.effect == "command_delay" && f.grade == Grade::kSupported) << f.statement;
}

TEST(TorqueLog, ADelayThatIsNotToldFromNoneLeavesTheRotorsOfARealRobot) { expect_rotors_of_the_quadruped(false); }

// Learnt from the other recording, the delay is 12 ms +- 1 ms. It leaves a twelfth less than friction and rotors do.
TEST(TorqueLog, ADelayThatPredictsHardlyBetterThanRotorsTakesNotTheirPlace) { expect_rotors_of_the_quadruped(true); }

TEST(TorqueLog, AFrozenLogIsLeftOutWithAWarning) {
  const Hypothesis hidden = make_arm_drives();
  Experiment e = make_simulated_experiment("torque_frozen", kArm, kArmJoints, hidden);
  Recording& r = e.recordings[0];
  for (JointColumns& joint : r.joints) {
    for (size_t k = r.size() / 2; k < r.size(); ++k) {
      joint.signal[0][k] = joint.signal[0][r.size() / 2];
      joint.signal[1][k] = 0.0;
      joint.signal[2][k] = k % 40 < 20 ? 50.0 : -50.0;
    }
  }
  const TorqueVerdict verdict = judge_torque(e, 1);
  EXPECT_THAT(verdict.evidence.warnings, testing::Contains(testing::HasSubstr("no joint moves")));
  expect_drives(verdict, hidden);
}

// A joint that is held, in a log with pauses: noise alone makes its effort's range the larger one at rest.
TEST(TorqueLog, PausesOfARobotWithAHeldJointAreNoFrozenLog) {
  TestNoise noise;
  constexpr long kRows = 2000;
  TorqueRecording r;
  r.step = 0.005;
  r.q.setZero(kRows, 2);
  r.effort.setZero(kRows, 2);
  Flags still(kRows);
  for (long k = 0; k < kRows; ++k) {
    still[k] = k % 1000 > 500;
    r.q(k, 0) = still[k] ? 0.0 : std::sin(0.02 * static_cast<double>(k));
    r.effort(k, 0) = still[k] ? 1.0 : 5.0 * std::cos(0.02 * static_cast<double>(k));
    r.effort(k, 1) = 0.1 * noise.draw() + (still[k] ? 0.5 * noise.draw() : 0.0);
  }
  r.v = r.q;
  EXPECT_FALSE(find_frozen(r, still).any());
  for (long k = 0; k < kRows; ++k) r.effort(k, 0) = still[k] ? (k % 40 < 20 ? 50.0 : -50.0) : r.effort(k, 0);
  EXPECT_TRUE(find_frozen(r, still).any());
}

// Commands are logged more often than readings: the rate of the law's effort is theirs.
TEST(TorqueLog, TheRateOfAServosCommandNeedsNoReading) {
  Recording r;
  r.joints.resize(1);
  std::vector<double> rate;
  for (int k = 0; k < 40; ++k) {
    r.time.push_back(0.005 * k);
    r.joints[0].command.push_back(0.4 * r.time.back());
    r.joints[0].signal[0].push_back(k % 2 == 0 ? 0.0 : NAN);
    rate.push_back(k % 2 == 0 ? 0.0 : NAN);
  }
  JointLaws laws;
  laws.kp = 50.0;
  const ServoSeries servo = calc_servo(r, 0, laws, rate);
  for (size_t k = 1; k < 39; ++k) EXPECT_NEAR(servo.command_rate[k], 50.0 * 0.4, 1e-9) << k;
}

}  // namespace
}  // namespace hrp::diagnosis
