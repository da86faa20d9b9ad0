// SPDX-License-Identifier: BSD-3-Clause
// Sensors behind the gears of a robot on a fixed base: what they read, what they tell, and what is refused.
#include <gmock/gmock.h>

#include "common/multibody/inverse_dynamics.h"
#include "common/multibody/kinematics.h"
#include "diagnosis/evidence/gear_deflection.h"
#include "diagnosis/link_evidence.h"
#include "diagnosis/model/nominal.h"
#include "tests/catch_complaint.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

LinkSensor make_torque(int joint) {
  LinkSensor s;
  s.kind = LinkSensorKind::kTorque;
  s.name = "/joint_states_link/" + kArmJoints[static_cast<size_t>(joint)] + "/effort";
  s.joint = joint;
  s.link = joint + 1;
  return s;
}

LinkSensor make_at(const Experiment& e, LinkSensorKind kind, const std::string& link) {
  LinkSensor s;
  s.kind = kind;
  s.name = kind == LinkSensorKind::kImu ? "/imu/hand" : "/wrench/hand";
  s.frame = e.robot.tree.find_frame(link);
  s.link = e.robot.tree.frames[static_cast<size_t>(s.frame)].link;
  return s;
}

Experiment make_arm(const std::string& name, const Hypothesis& hidden = {}) {
  return simulate_arm("link_" + name, hidden);
}

// Joint torque sensors, a wrench and an IMU at the forearm, a second encoder at the elbow.
LinkSensors make_all(const Experiment& e) {
  LinkSensors all;
  all.sensors = {make_torque(kShoulder), make_torque(kElbow), make_at(e, LinkSensorKind::kWrench, "fore"),
                 make_at(e, LinkSensorKind::kImu, "fore")};
  all.sensors.back().p_FS = Vector3d(0.1, 0.02, -0.03);
  return all;
}

// Fills the columns of the sensors from the recorded motion of a robot that has `hidden` effects of links.
void record(const LinkSensors& sensors, const std::vector<Effect>& hidden, Experiment* e) {
  const TorqueData motion = make_torque_data(*e);
  LinkReadings readings = make_link_readings(*e, sensors, hidden);
  TestNoise noise;
  for (const TorqueRecording& r : motion.recordings) {
    Recording& out = e->recordings[r.index];
    for (const ReadingGroup& group : readings.groups()) {
      for (int i = 0; i < group.size; ++i) {
        std::vector<double>& column = out.other[group.name + (group.size == 1 ? "" : std::string("/") + "xyz"[i])];
        column.assign(out.size(), 0.0);
      }
    }
    for (size_t k = 0; k < out.size(); ++k) {
      const long row = std::min<long>(static_cast<long>(k), r.q.rows() - 1);
      readings.move(r.q.row(row), r.v.row(row), r.a.row(row));
      const Eigen::VectorXd value = readings.calc();
      for (const ReadingGroup& group : readings.groups()) {
        for (int i = 0; i < group.size; ++i)
          out.other[group.name + (group.size == 1 ? "" : std::string("/") + "xyz"[i])][k] =
              value[group.first + i] + 0.01 * noise.draw();
      }
    }
    for (const auto& column : out.other) e->other_noise[column.first] = {0.01, true};
  }
}

void shift(const std::string& column, double value, Experiment* e) {
  for (Recording& r : e->recordings) {
    for (double& x : r.other.at(column)) x += value;
  }
}

LinkVerdict judge(const Experiment& e, const LinkSensors& sensors) {
  return judge_links(e, make_torque_data(e), sensors, {});
}

TEST(LinkSensors, TorqueAndWrenchAreThoseOfRecursiveNewtonEuler) {
  const Experiment e = make_arm("rne");
  LinkReadings readings = make_link_readings(e, make_all(e), {});
  Eigen::Vector2d q(0.3, -0.8), v(1.2, -2.0), a(5.0, 9.0);
  readings.move(q, v, a);
  const Eigen::VectorXd value = readings.calc();
  Model model(e.robot.tree, e.scenario.gravity_W);
  Data data(model);
  State state = make_state(model);
  state.q = q;
  state.qd = v;
  update_kinematics(model, state, &data);
  Eigen::VectorXd tau(2);
  calc_inverse_dynamics(model, a, nullptr, &data, &tau);
  // Two algorithms, the same equations: rounding only.
  EXPECT_NEAR(value[0], tau[0], 1e-12);
  EXPECT_NEAR(value[1], tau[1], 1e-12);
  const Vector6d joint = get_joint_wrench(data, 2);
  const Matrix3d R = get_pose(data, 2).R.transpose();
  EXPECT_NEAR((value.segment<3>(2) + R * joint.tail<3>()).norm(), 0.0, 1e-12);
  EXPECT_NEAR((value.segment<3>(5) + R * joint.head<3>()).norm(), 0.0, 1e-12);
}

TEST(LinkSensors, AHangingForearmPullsDownwardsAndAnImuAtRestPointsUp) {
  const Experiment e = make_arm("rest");
  LinkReadings readings = make_link_readings(e, make_all(e), {});
  readings.move(Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero());
  const Eigen::VectorXd value = readings.calc();
  EXPECT_NEAR(value[4], -9.81, 1e-9);        // 1 kg; force along z
  EXPECT_NEAR(value[6], 9.81 * 0.15, 1e-9);  // its centre 0.15 m out: torque about y
  EXPECT_NEAR(value[13], 9.81, 1e-9);        // specific force
}

TEST(LinkSensors, AWristWrenchNamesThePayloadBeyondIt) {
  Experiment e = make_arm("payload");
  LinkSensors wrench;
  wrench.sensors = {make_at(e, LinkSensorKind::kWrench, "fore")};
  record(wrench, {{EffectId::kPayload, at_link(kFore), {0.4, 0.3, 0.02, 0.0, 0.0}}}, &e);
  const LinkVerdict verdict = judge(e, wrench);
  ASSERT_EQ(verdict.evidence.findings.size(), 1u);
  const Finding& f = verdict.evidence.findings[0];
  EXPECT_EQ(f.effect, "payload") << f.statement;
  EXPECT_EQ(f.grade, Grade::kSupported) << f.statement;
  EXPECT_NEAR(f.parameters[0].value[0], 0.4, 0.004) << f.statement;  // 1 %: noise of 0.01 N beside 4 N
  EXPECT_NEAR(f.parameters[1].value[0], 0.3, 0.003) << f.statement;
  EXPECT_TRUE(verdict.to_noise);
}

TEST(LinkSensors, ABiasOfASensorIsNoMass) {
  Experiment e = make_arm("bias");
  LinkSensors all = make_all(e);
  record(all, {}, &e);
  shift("/wrench/hand/force/z", 1.5, &e);
  const LinkVerdict verdict = judge(e, all);
  ASSERT_EQ(verdict.evidence.findings.size(), 1u);
  const Finding& f = verdict.evidence.findings[0];
  EXPECT_EQ(f.effect, "sensor_bias") << f.statement;
  EXPECT_EQ(f.where.begin().value(), "/wrench/hand/force");
  EXPECT_NEAR(f.parameters[0].value[2], 1.5, 0.01);
}

// A fault of a drive's own log is of no link and of no encoder's zero.
TEST(LinkSensors, ACertainBiasOfAJointsVelocityStaysBesideThem) {
  Experiment e = make_arm("velocity_bias");
  LinkSensors wrench;
  wrench.sensors = {make_at(e, LinkSensorKind::kWrench, "fore")};
  record(wrench, {}, &e);
  Reports reports;
  reports.report = {
      {"verdict", "explained"}, {"fit", {{"per_signal", Json::object()}}}, {"prediction", {{"method", "simulation"}}}};
  for (const char* key : {"mismatch", "remaining", "not_identifiable", "warnings", "unexplained"})
    reports.report[key] = Json::array();
  const Json bias = {{"effect", "sensor_bias"},
                     {"where", {{"sensor", "/joint_states/elbow/velocity"}}},
                     {"grade", "certain"},
                     {"parameters", {{"value", {{"value", 0.09}, {"std", 0.001}, {"unit", "rad/s"}}}}}};
  reports.report["findings"] = Json::array({bias});
  std::set<std::string> compared;
  add_link_evidence(
      e, wrench, 1, [](const std::string&) {}, &reports, &compared);
  ASSERT_EQ(reports.report["findings"].size(), 1u);
  EXPECT_EQ(reports.report["findings"][0]["effect"], "sensor_bias");
  EXPECT_EQ(reports.report["verdict"], "explained");
}

TEST(LinkSensors, NothingIsNamedWhereNothingIsMissing) {
  Experiment e = make_arm("nothing");
  LinkSensors all = make_all(e);
  record(all, {}, &e);
  const LinkVerdict verdict = judge(e, all);
  EXPECT_THAT(verdict.evidence.findings, testing::IsEmpty());
  EXPECT_FALSE(verdict.mismatch);
}

TEST(LinkSensors, ATurnedImuComesOutWithItsAnglesHoweverLarge) {
  Experiment e = make_arm("turned");
  LinkSensors all = make_all(e);
  record(all, {}, &e);
  const Vector3d rpy(0.1, -0.25, 0.15);
  const Matrix3d R = (Eigen::AngleAxisd(rpy.z(), Vector3d::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Vector3d::UnitY()) *
                      Eigen::AngleAxisd(rpy.x(), Vector3d::UnitX()))
                         .toRotationMatrix();
  for (Recording& r : e.recordings) {
    for (const char* reading : {"/imu/hand/angular_velocity/", "/imu/hand/linear_acceleration/"}) {
      for (size_t k = 0; k < r.size(); ++k) {
        Vector3d x;
        for (int i = 0; i < 3; ++i) x[i] = r.other.at(reading + std::string(1, "xyz"[i]))[k];
        x = R.transpose() * x;
        for (int i = 0; i < 3; ++i) r.other.at(reading + std::string(1, "xyz"[i]))[k] = x[i];
      }
    }
  }
  const LinkVerdict verdict = judge(e, all);
  ASSERT_EQ(verdict.evidence.findings.size(), 1u);
  const Finding& f = verdict.evidence.findings[0];
  EXPECT_EQ(f.effect, "sensor_misalignment") << f.statement;
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(f.parameters[0].value[static_cast<size_t>(i)], rpy[i], 0.002) << f.statement;  // 1 % of 0.25 rad
}

TEST(LinkSensors, ALateImuComesOutInTenthsOfMilliseconds) {
  Experiment e = make_arm("late");
  LinkSensors all = make_all(e);
  record(all, {}, &e);
  for (Recording& r : e.recordings) {
    for (auto& [name, column] : r.other) {
      if (name.rfind("/imu", 0) == 0)
        std::rotate(column.rbegin(), column.rbegin() + 8, column.rend());  // 40 ms at 200 Hz
    }
  }
  const LinkVerdict verdict = judge(e, all);
  ASSERT_FALSE(verdict.evidence.findings.empty());
  EXPECT_EQ(verdict.evidence.findings[0].effect, "sensor_delay") << verdict.evidence.findings[0].statement;
  EXPECT_NEAR(verdict.evidence.findings[0].parameters[0].value[0], 0.040,
              0.0004);  // 1 %: the ends of the recordings are turned over
}

const Finding* find(const std::vector<Finding>& list, const std::string& effect) {
  for (const Finding& f : list) {
    if (f.effect == effect) return &f;
  }
  return nullptr;
}

// The load pulls at the sensor and the drive, the friction at the drive alone.
TEST(LinkSensors, ATorqueSensorBehindTheGearTellsFrictionFromAWrongPayload) {
  const std::vector<double> load{0.5, 0.3, 0.0, 0.0, 0.0};
  Experiment e = make_arm("friction", {{EffectId::kPayload, kFore, load},
                                       {EffectId::kCoulomb, kShoulder, {1.5, 0.0, 5e-4}},
                                       {EffectId::kViscous, kShoulder, {0.8}}});
  LinkSensors torque;
  torque.sensors = {make_torque(kShoulder), make_torque(kElbow)};
  record(torque, {{EffectId::kPayload, at_link(kFore), load}}, &e);
  const LinkVerdict links = judge(e, torque);
  ASSERT_EQ(links.evidence.findings.size(), 1u);
  EXPECT_EQ(links.evidence.findings[0].effect, "payload") << links.evidence.findings[0].statement;
  EXPECT_NEAR(links.evidence.findings[0].parameters[0].value[0], 0.5, 0.025);  // 5 %: what the report promises
  const TorqueVerdict drives = judge_drives(e, torque, links, 1);
  const Finding* dry = find(drives.evidence.findings, "coulomb_friction");
  ASSERT_NE(dry, nullptr);
  EXPECT_NEAR(dry->parameters[0].value[0], 1.5, 0.075) << dry->statement;
  EXPECT_EQ(find(drives.evidence.findings, "payload"), nullptr);
  for (const Finding& f : drives.evidence.findings) EXPECT_EQ(f.where.value("joint", ""), "shoulder") << f.statement;
}

// The elbow's motor runs ahead of its link by what the gear gives under the torque that it passes on.
Experiment make_two_encoders(const std::string& name, double stiffness, double gap, double zero, bool gravity = true,
                             const Hypothesis& hidden = {}) {
  Experiment e = make_arm(name, hidden);
  if (!gravity) e.scenario.gravity_W.setZero();
  const TorqueData motion = make_torque_data(e);
  LinkSensors predicted;
  predicted.sensors = {make_torque(kElbow)};
  LinkReadings readings = make_link_readings(e, predicted, {});
  TestNoise noise;
  for (const TorqueRecording& r : motion.recordings) {
    Recording& out = e.recordings[r.index];
    std::vector<double>&motor = out.joints[kElbow].signal[0], &link = out.other["/joint_states_link/elbow/position"];
    for (size_t k = 0; k < out.size(); ++k) {
      const long row = std::min<long>(static_cast<long>(k), r.q.rows() - 1);
      readings.move(r.q.row(row), r.v.row(row), r.a.row(row));
      const double torque = readings.calc()[0], side = std::tanh(torque / 0.02);
      link.push_back(r.q(row, kElbow) + zero + 2e-5 * noise.draw());
      motor[k] = r.q(row, kElbow) + torque / stiffness + 0.5 * gap * side + 2e-5 * noise.draw();
    }
  }
  e.other_noise["/joint_states_link/elbow/position"] = {2e-5, true};
  return e;
}

GearVerdict judge_gear(const std::string& name, double stiffness, double gap, double zero, bool gravity = true) {
  const Experiment e = make_two_encoders(name, stiffness, gap, zero, gravity);
  LinkSensors encoder;
  encoder.link_encoders = {kElbow};
  return judge_gears(e, make_torque_data(e), encoder, {}).at(0);
}

TEST(LinkSensors, TwoEncodersGiveTheGearsStiffnessWithinFivePercent) {
  const GearVerdict gear = judge_gear("stiffness", 800.0, 0.0, 0.0);
  ASSERT_EQ(gear.findings.size(), 1u);
  EXPECT_EQ(gear.findings[0].effect, "joint_elasticity") << gear.findings[0].statement;
  EXPECT_NEAR(gear.findings[0].parameters[0].value[0], 800.0, 40.0) << gear.findings[0].statement;
  EXPECT_FALSE(gear.zero_found);
}

TEST(LinkSensors, TwoEncodersTellPlayFromGive) {
  const GearVerdict gear = judge_gear("play", 8000.0, 0.01, 0.0, false);  // gravity would hold the teeth on one side
  ASSERT_EQ(gear.findings.size(), 1u);
  EXPECT_EQ(gear.findings[0].effect, "backlash") << gear.findings[0].statement;
  EXPECT_NEAR(gear.findings[0].parameters[0].value[0], 0.01, 0.001);  // a tenth: the filter rounds the change of sides
}

TEST(LinkSensors, PlayUnderATorqueThatKeepsItsSignLooksLikeAZero) {
  const GearVerdict gear = judge_gear("one_sided", 8000.0, 0.01, 0.0);
  EXPECT_TRUE(gear.one_sided);
  EXPECT_EQ(find(gear.findings, "backlash"), nullptr);
}

TEST(LinkSensors, AShiftedSecondEncoderIsNoGear) {
  const GearVerdict gear = judge_gear("zero", 1e9, 0.0, 0.02);
  EXPECT_THAT(gear.findings, testing::IsEmpty());
  EXPECT_TRUE(gear.zero_found);
  EXPECT_NEAR(gear.zero, -0.02, 1e-4);
}

// Root mean square [N m] of what the elbow's effort misses, along the motion that the torque stage takes for the links.
double calc_missing(const Experiment& e) {
  double squares = 0.0, n = 0.0;
  for (const TorqueRecording& r : make_torque_data(e).recordings) {
    squares += r.missing.col(kElbow).squaredNorm();
    n += static_cast<double>(r.kept());
  }
  return std::sqrt(squares / n);
}

// Give of 15 N m/rad changes the motor's acceleration, not that of the link.
TEST(LinkSensors, TorqueBehindAGearThatGivesIsThatOfTheLinksMotion) {
  Experiment e = make_two_encoders("soft_gear", 15.0, 0.0, 0.0);
  e.scenario.drive = "effort";
  const double by_link = calc_missing(e);
  for (Recording& r : e.recordings) r.other.clear();
  const double by_motor = calc_missing(e);
  EXPECT_LT(by_link, 0.1 * by_motor) << by_link << " " << by_motor;
}

TEST(LinkSensors, ASecondEncoderThatIsFarOffIsNotBelieved) {
  Experiment e = make_two_encoders("wrong_encoder", 1e9, 0.0, 0.3);
  e.scenario.drive = "effort";
  const double with = calc_missing(e);
  for (Recording& r : e.recordings) r.other.clear();
  EXPECT_EQ(with, calc_missing(e));
}

TEST(LinkSensors, RatesInDegreesAndWrenchesOfTheOtherSignAreRefusedByName) {
  Experiment e = make_arm("units");
  LinkSensors all = make_all(e);
  record(all, {}, &e);
  Experiment turned = e;
  for (Recording& r : e.recordings) {
    for (const char* axis : {"x", "y", "z"}) {
      for (double& x : r.other.at(std::string("/imu/hand/angular_velocity/") + axis)) x *= 180.0 / M_PI;
    }
  }
  EXPECT_THAT(catch_complaint([&] { judge(e, all); }),
              testing::HasSubstr("/imu/hand/angular_velocity: reads 57.3 times"));
  for (Recording& r : turned.recordings) {
    for (const char* part : {"force/x", "force/y", "force/z", "torque/x", "torque/y", "torque/z"}) {
      for (double& x : r.other.at(std::string("/wrench/hand/") + part)) x *= -1.0;
    }
  }
  EXPECT_THAT(catch_complaint([&] { judge(turned, all); }), testing::HasSubstr("/wrench/hand/force: reads -1 times"));
}

TEST(LinkSensors, ADeclaredSensorThatWasNotRecordedIsRefused) {
  Experiment e = make_arm("declared");
  e.scenario.text += "sensors: {joint_torque: [elbow]}\n";
  EXPECT_THAT(catch_complaint([&] { find_link_sensors(e); }),
              testing::HasSubstr("/joint_states_link/elbow/effort: is missing: sensors.joint_torque"));
}

TEST(LinkSensors, AnImuWithoutAllAxesIsComparedWithNothingAndSaysWhy) {
  Experiment e = make_arm("gyro_alone");
  ImuSpec imu;
  imu.name = "hand";
  imu.link = "fore";
  e.scenario.sensors.imus.push_back(imu);
  for (Recording& r : e.recordings) r.other["/imu/hand/angular_velocity/y"].assign(r.size(), 0.1);
  EXPECT_THAT(find_link_sensors(e).notes,
              testing::ElementsAre("/imu/hand is compared only with three rates and three accelerations"));
}

TEST(LinkSensors, JointsThatTheRobotHasNotAreRefusedWithTheNearest) {
  Experiment e = make_arm("unknown");
  Experiment declared = e;
  declared.scenario.text += "sensors: {link_encoder: [elbo]}\n";
  EXPECT_THAT(catch_complaint([&] { find_link_sensors(declared); }),
              testing::HasSubstr("no joint 'elbo'; did you mean 'elbow'?"));
  for (Recording& r : e.recordings) r.other["/joint_states_link/elbw/effort"].assign(r.size(), 1.0);
  EXPECT_THAT(catch_complaint([&] { find_link_sensors(e); }),
              testing::HasSubstr("no joint 'elbw'; did you mean 'elbow'?"));
}

}  // namespace
}  // namespace hrp::diagnosis
