// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/diagnostics.h"
#include "diagnosis/data/csv.h"
#include "diagnosis/data/noise.h"
#include "diagnosis/data/plausibility.h"
#include "diagnosis/data/recording.h"
#include "diagnosis/data/repair.h"
#include "diagnosis/data/smooth.h"
#include "tests/catch_complaint.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

std::string write_file(const std::string& name, const std::string& text) {
  std::string path = (std::filesystem::temp_directory_path() / ("hrp_diagnosis_" + name)).string();
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

std::string read_error(const std::string& path) {
  std::vector<std::string> warnings;
  return catch_complaint([&] { read_csv(path, &warnings); });
}

TEST(Csv, NamesLineAndColumnOfACellThatIsNoNumber) {
  const std::string path = write_file("bad.csv", "time,/joint_states/a/position\n0,1\n0.1,x2\n0.2,3\n");
  EXPECT_THAT(read_error(path), testing::HasSubstr("bad.csv:3:2:"));
}

TEST(Csv, RefusesRowsWithTooManyCellsAndRepeatedColumns) {
  EXPECT_THAT(read_error(write_file("wide.csv", "time,a\n0,1,2\n")), testing::HasSubstr("wide.csv:2:"));
  EXPECT_THAT(read_error(write_file("twice.csv", "time,a,a\n0,1,2\n1,1,2\n")), testing::HasSubstr("twice"));
}

TEST(Csv, TakesMissingCellsAsMissingAndDropsACutLastLine) {
  std::vector<std::string> warnings;
  const Table table = read_csv(write_file("gaps.csv", "time,a,b\r\n0,1,\r\n0.1,nan,2\r\n0.2,3"), &warnings);
  ASSERT_EQ(table.rows(), 2u);
  EXPECT_TRUE(std::isnan(table.columns[2][0]));
  EXPECT_TRUE(std::isnan(table.columns[1][1]));
  EXPECT_EQ(warnings.size(), 1u);
}

// A continuous joint that turns at 3 rad/s, logged between -pi and pi.
TEST(Repair, AnAngleThatWrapsIsCountedOn) {
  std::vector<double> angle;
  for (int k = 0; k < 2000; ++k) angle.push_back(std::remainder(0.006 * k - 1.0, 2.0 * M_PI));
  EXPECT_EQ(unwrap_angle(&angle), 2);
  for (int k = 0; k < 2000; ++k) ASSERT_NEAR(angle[static_cast<size_t>(k)], 0.006 * k - 1.0, 1e-9) << k;
}

// A wheel at 57 turns a second whose encoder is read every 20 ms, logged every 5 ms: it turns by more than once between
// readings.
TEST(Repair, AWheelWhoseTurnsAreCountedDoesNotWrap) {
  std::vector<double> angle;
  for (int k = 0; k < 200; ++k) {
    const int reading = k / 4;
    angle.push_back(2.0 * M_PI * 57.0 * 0.02 * reading);
  }
  const std::vector<double> logged = angle;
  EXPECT_EQ(unwrap_angle(&angle), 0);
  EXPECT_EQ(angle, logged);
}

TEST(Repair, ASingleSampleThatJumpsAndReturnsIsLeftOutAndAStepIsNot) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0.0, 1e-4);
  std::vector<double> signal;
  for (int k = 0; k < 1000; ++k) signal.push_back(std::sin(0.01 * k) + (k >= 500 ? 0.5 : 0.0) + normal(random));
  signal[300] += 40.0;
  EXPECT_EQ(drop_spikes(&signal, 0.03), 1);
  EXPECT_TRUE(std::isnan(signal[300]));
  for (size_t k : {299u, 301u, 499u, 500u}) EXPECT_TRUE(std::isfinite(signal[k])) << k;
}

// Dry friction turns an effort at once, and a drive may switch it every sample: that is what it does.
TEST(Repair, AnEffortThatSwitchesAllTheTimeStays) {
  std::vector<double> effort;
  for (int k = 0; k < 1000; ++k) effort.push_back(k % 7 == 0 ? 5.0 : 0.001 * (k % 3));
  EXPECT_EQ(drop_spikes(&effort, 2.0), 0);
}

// A body that turns about z at 2 rad/s, logged with either sign, and in every second row only.
TEST(Repair, AQuaternionAndItsNegativeAreOneAttitude) {
  std::array<std::vector<double>, 4> q;
  for (int k = 0; k < 1000; ++k) {
    const double sign = k % 2 ? std::nan("") : k / 100 % 2 ? -1.0 : 1.0, half = 0.01 * k;
    q[0].push_back(0.0 * sign);
    q[1].push_back(0.0 * sign);
    q[2].push_back(sign * std::sin(half));
    q[3].push_back(sign * std::cos(half));
  }
  EXPECT_TRUE(std::isnan(repair_attitude({&q[0], &q[1], &q[2], &q[3]})));
  for (size_t k = 0; k < 1000; k += 2) ASSERT_NEAR(q[3][k], std::cos(0.01 * static_cast<double>(k)), 1e-12) << k;
}

// An IMU that estimates no attitude logs zeros.
TEST(Repair, AQuaternionThatIsNoRotationIsNoReading) {
  std::array<std::vector<double>, 4> q;
  for (int k = 0; k < 10; ++k) {
    for (std::vector<double>& part : q) part.push_back(k < 4 ? 0.0 : 0.5);
  }
  EXPECT_EQ(repair_attitude({&q[0], &q[1], &q[2], &q[3]}), 0.0);
  for (size_t k = 0; k < 10; ++k) EXPECT_EQ(std::isnan(q[0][k]), k < 4) << k;
}

// What a trunk says that turns by `swing` [rad] about x; `w`, of its IMU's constant attitude [0, 0, 0, w].
Experiment check_still_attitude(double swing, double w) {
  Experiment e;
  e.robot.tree.links.resize(1);
  e.scenario.sensors.imus.resize(1);
  e.scenario.sensors.imus[0].name = "trunk";
  Recording& r = e.recordings.emplace_back();
  r.spec.name = "a.csv";
  for (int k = 0; k < 500; ++k) {
    r.time.push_back(0.005 * k);
    r.other["/imu/trunk/angular_velocity/x"].push_back(0.01 + 5.0 * swing * std::cos(5.0 * r.time.back()));
    for (const char axis : {'x', 'y', 'z', 'w'})
      r.other[std::string("/imu/trunk/orientation/") + axis].push_back(axis == 'w' ? w : 0.0);
  }
  check_plausibility(&e);
  repair_recording(e, &r, &e.warnings);
  return e;
}

TEST(Suspicions, AnAttitudeThatStaysWhileTheGyroscopeTurnsWasNotEstimated) {
  const Experiment turned = check_still_attitude(0.2, 1.0);
  EXPECT_THAT(turned.warnings,
              testing::ElementsAre(
                  "a.csv: /imu/trunk/orientation never changes although the gyroscope does: taken as not recorded"));
  EXPECT_FALSE(turned.recordings[0].has("/imu/trunk/orientation/w"));
  EXPECT_TRUE(check_still_attitude(0.001, 1.0).recordings[0].has("/imu/trunk/orientation/w"));  // below what was logged
}

TEST(Suspicions, AnAttitudeOfZerosWasNotEstimated) {
  const Experiment e = check_still_attitude(0.001, 0.0);
  EXPECT_THAT(e.warnings, testing::ElementsAre("a.csv: /imu/trunk/orientation: a quaternion of norm 0 is no attitude, "
                                               "expected 1; its columns are left out"));
  EXPECT_FALSE(e.recordings[0].has("/imu/trunk/orientation/x"));
}

// Adds a recording whose knee moves by `swing` [rad] beside body sensors that read `value`, and `more` times the knee.
void add_body_log(const std::string& name, bool train, double swing, double value, double more, Experiment* e) {
  Recording& r = e->recordings.emplace_back();
  r.spec.name = name;
  r.spec.train = train;
  r.joints.resize(1);
  for (int k = 0; k < 500; ++k) {
    r.time.push_back(0.005 * k);
    r.joints[0].signal[0].push_back(swing * std::sin(5.0 * r.time.back()));
    for (const char* column :
         {"/imu/trunk/angular_velocity/x", "/imu/trunk/linear_acceleration/z", "/wrench/foot/force/z"})
      r.other[column].push_back(value + more * r.joints[0].signal[0].back());
  }
}

Experiment make_knee_with_body_sensors() {
  Experiment e;
  e.robot.tree.links.resize(2);
  e.robot.tree.links[1].joint.name = "knee";
  e.scenario.floating_base = true;
  e.scenario.sensors.imus.resize(1);
  e.scenario.sensors.imus[0].name = "trunk";
  e.scenario.sensors.wrenches.resize(1);
  e.scenario.sensors.wrenches[0].name = "foot";
  return e;
}

// A robot whose knee moves by `swing` [rad] beside a body sensor that reads `value` all the time.
Experiment check_still_sensors(double swing, double value) {
  Experiment e = make_knee_with_body_sensors();
  add_body_log("a.csv", true, swing, value, 0.0, &e);
  check_plausibility(&e);
  return e;
}

TEST(Suspicions, SensorsOfTheBodyThatStayWhileItsJointsMoveWereNotRead) {
  const Experiment dead = check_still_sensors(0.2, 2.06);
  EXPECT_THAT(dead.warnings, testing::ElementsAre(
                                 "a.csv: /imu/trunk never changes although the joints move: taken as not recorded",
                                 "a.csv: /wrench/foot never changes although the joints move: taken as not recorded"));
  EXPECT_TRUE(dead.recordings[0].other.empty());
  const Experiment air = check_still_sensors(0.2, 0.0);
  EXPECT_FALSE(air.recordings[0].has("/imu/trunk/angular_velocity/x"));
  EXPECT_TRUE(air.recordings[0].has("/wrench/foot/force/z")) << "zeros of a force are those of a foot in the air";
  EXPECT_EQ(check_still_sensors(0.001, 2.06).recordings[0].other.size(), 3u) << "nothing moves";
}

TEST(Suspicions, ASensorThatIsDeadInOneRecordingStaysInTheOthers) {
  Experiment e = make_knee_with_body_sensors();
  add_body_log("a.csv", true, 0.2, 2.06, 1.0, &e);
  add_body_log("b.csv", true, 0.2, 2.06, 0.0, &e);
  add_body_log("c.csv", false, 0.2, 2.06, 1.0, &e);
  check_plausibility(&e);
  ASSERT_EQ(e.recordings.size(), 2u);
  EXPECT_EQ(e.recordings[0].spec.name, "a.csv");
  EXPECT_EQ(e.recordings[1].spec.name, "c.csv");
  EXPECT_TRUE(e.recordings[0].has("/imu/trunk/angular_velocity/x"));
  EXPECT_THAT(e.warnings, testing::Contains("b.csv: /imu/trunk never changes although the joints move: this recording "
                                            "is left out, so that the others keep it"));
}

TEST(Suspicions, ASensorThatIsDeadInTheOnlyHeldOutRecordingIsNotUsed) {
  Experiment e = make_knee_with_body_sensors();
  add_body_log("a.csv", true, 0.2, 2.06, 1.0, &e);
  add_body_log("b.csv", false, 0.2, 2.06, 0.0, &e);
  check_plausibility(&e);
  EXPECT_EQ(e.recordings.size(), 2u);
  EXPECT_TRUE(e.recordings[1].other.empty());
  EXPECT_THAT(e.warnings, testing::Contains("b.csv: /imu/trunk never changes although the joints move: taken as not "
                                            "recorded, also in the other recordings"));
}

TEST(Noise, IsFoundUnderASmoothMotion) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0.0, 0.003);
  std::vector<double> signal;
  for (int k = 0; k < 4000; ++k) signal.push_back(std::sin(0.01 * k) + normal(random));
  // 4000 samples of third differences know a standard deviation to about 4 %.
  EXPECT_NEAR(estimate_noise(signal), 0.003, 0.003 * 0.12);
}

TEST(Smoothing, GivesDerivativesOfACubicExactlyOnIrregularStamps) {
  std::vector<double> time, values, value, rate, second;
  for (int k = 0; k < 60; ++k) {
    time.push_back(0.01 * k + 0.003 * std::sin(1.7 * k));
    const double t = time.back();
    values.push_back(1.0 + 2.0 * t - 3.0 * t * t + 4.0 * t * t * t);
  }
  smooth_series(time, values, 6, &value, &rate, &second);
  for (size_t k = 0; k < time.size(); ++k) {
    const double t = time[k];
    EXPECT_NEAR(rate[k], 2.0 - 6.0 * t + 12.0 * t * t, 1e-6);  // 1e-12 of ridge in the local fits, scaled
    EXPECT_NEAR(second[k], -6.0 + 24.0 * t, 1e-4);
  }
}

// What loading recordings of an elbow says; `columns` and `write_rows` are the files' contents.
std::string load_elbow(const std::string& name, const std::string& columns,
                       const std::function<void(std::ostream*)>& write_rows) {
  const std::string folder = (std::filesystem::temp_directory_path() / ("hrp_diagnosis_" + name)).string() + "/";
  std::filesystem::create_directories(folder);
  std::ofstream(folder + "robot.urdf") << R"(<robot name="arm"><link name="base"/><link name="fore"><inertial>
    <origin xyz="0.1 0 0"/><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
    </link><joint name="elbow" type="revolute"><parent link="base"/><child link="fore"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="50" velocity="10"/></joint></robot>)";
  std::ofstream(folder + "experiment.yaml")
      << "robot: robot.urdf\nbase: fixed\nservo: {default: {kp: 100, kd: 0, effort_limit: 50}}\n"
         "recordings:\n- {file: a.csv, role: train}\n- {file: b.csv, role: validate}\n";
  for (const char* file : {"a.csv", "b.csv"}) {
    std::ofstream csv(folder + file);
    csv << "time,/joint_commands/elbow/position,/joint_states/elbow/position" << columns << "\n";
    write_rows(&csv);
  }
  try {
    load_experiment(folder + "experiment.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

// An elbow whose logged effort is `sign` times its servo's law (1 N m at rest and `swing` about it) and `shift` on top.
std::string load_effort(const std::string& name, double swing, double sign, double shift) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0.0, 0.03);
  return load_elbow(name, ",/joint_states/elbow/effort", [&](std::ostream* csv) {
    for (int k = 0; k < 1000; ++k) {
      const double effort = -1.0 + swing * std::sin(0.02 * k);
      *csv << 0.005 * k << "," << 0.5 << "," << 0.5 - effort / 100 << "," << sign * effort + shift + normal(random)
           << "\n";
    }
  });
}

TEST(Suspicions, AShiftedEffortOfAJointAtRestIsNoTurnedSign) {
  EXPECT_EQ(load_effort("shifted", 0.0, 1.0, 1.95), "");
  EXPECT_EQ(load_effort("turned", 0.5, -1.0, 0.0), "");
}

// What never changes has no slope: the sum of a thousand equal numbers is rounded, and its mean is not the number.
TEST(Suspicions, ACommandThatStaysWhileTheJointRestsIsNoTurnedSign) {
  EXPECT_EQ(load_elbow("still", "",
                       [](std::ostream* csv) {
                         for (int k = 0; k < 3001; ++k) *csv << 0.005 * k << ",1.21,1.174141\n";
                       }),
            "");
}

// Two joints that swing by `swing` N m about 1 and 3 N m of effort; each one's log reads the other's.
std::string load_crossed(const std::string& name, double swing) {
  const auto folder = std::filesystem::temp_directory_path() / ("hrp_diagnosis_" + name);
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "robot.urdf") << kArm;
  std::ofstream(folder / "experiment.yaml")
      << "robot: robot.urdf\nbase: fixed\nservo: {default: {kp: 100, kd: 0, effort_limit: 50}}\n"
         "recordings:\n- {file: a.csv, role: train}\n";
  std::ofstream csv(folder / "a.csv");
  csv << "time";
  for (const char* j : {"shoulder", "elbow"})
    csv << ",/joint_commands/" << j << "/position,/joint_states/" << j << "/position,/joint_states/" << j << "/effort";
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0.0, 0.03);
  for (int k = 0; k < 1000; ++k) {
    const double effort[] = {1.0 + swing * std::sin(0.02 * k), 3.0 + swing * std::sin(0.031 * k)};
    csv << "\n" << 0.005 * k;
    for (int j = 0; j < 2; ++j)
      csv << "," << 0.5 << "," << 0.5 - effort[j] / 100 << "," << effort[1 - j] + normal(random);
  }
  csv << "\n";
  csv.close();
  try {
    load_experiment((folder / "experiment.yaml").string());
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

// Biases of two logs may bring the constant of each near the other's.
TEST(Suspicions, EffortsOfJointsThatHoldStillAreNotExchangedForBeingNearEachOthers) {
  EXPECT_EQ(load_crossed("crossed_still", 0.0), "");
  EXPECT_THAT(load_crossed("crossed", 0.5), testing::HasSubstr("exchanged"));
}

// An arm of two joints with a finger, and a recording of two joints of these names.
Experiment load_arm_with_finger(const std::string& first, const std::string& second, double izz = 0.01,
                                const std::string& more = "") {
  const auto folder = std::filesystem::temp_directory_path() /
                      ("hrp_diagnosis_finger_" + first + "_" + second + "_" + std::to_string(izz));
  std::filesystem::create_directories(folder);
  std::string urdf = R"(<robot name="arm"><link name="base"/>)", parent = "base";
  for (const char* joint : {"shoulder", "elbow", "finger"}) {
    urdf +=
        "<link name=\"" + std::string(joint) +
        "_link\"><inertial><mass value=\"1\"/><inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"" +
        std::to_string(izz) +
        "\"/></inertial></link>"
        "<joint name=\"" +
        joint + "\" type=\"revolute\"><parent link=\"" + parent + "\"/><child link=\"" + joint +
        "_link\"/>"
        "<axis xyz=\"0 1 0\"/><limit lower=\"-3\" upper=\"3\" effort=\"50\" velocity=\"10\"/></joint>";
    parent = std::string(joint) + "_link";
  }
  std::ofstream(folder / "robot.urdf") << urdf + "</robot>";
  std::ofstream csv(folder / "r.csv");
  csv << "time";
  for (const std::string& joint : {first, second})
    csv << ",/joint_states/" << joint << "/position,/joint_states/" << joint << "/effort";
  for (int k = 0; k < 400; ++k) {
    const double t = 0.005 * k;
    csv << "\n" << t;
    for (double w : {2.0, 3.1}) csv << "," << 0.5 * std::sin(w * t) << "," << std::sin(w * t + 0.3);
  }
  csv << "\n";
  csv.close();
  std::ofstream(folder / "experiment.yaml")
      << "robot: robot.urdf\nbase: fixed\ndrive: effort\nservo: {joints: {finger: {kp: 5, kd: 0.1}}}\nrecordings:\n- "
         "{file: r.csv, role: train}\n"
      << more;
  return load_experiment((folder / "experiment.yaml").string());
}

// A degree log of this joint would end at 172: a gear of 100 turns its motor by more.
TEST(Suspicions, AnAngleBeyondAnyDegreesIsAskedForAsTheMotorsBeforeItsGear) {
  const std::string said = load_elbow("motor_side", "", [](std::ostream* csv) {
    for (int k = 0; k < 400; ++k)
      *csv << 0.01 * k << "," << std::sin(0.01 * k) << "," << 220.0 * std::sin(0.01 * k - 0.05) << "\n";
  });
  EXPECT_THAT(said, testing::HasSubstr("/joint_states/elbow/position"));
  EXPECT_THAT(said, testing::HasSubstr("the angle of the motor, before a gear of at least"));
  EXPECT_THAT(said, testing::Not(testing::HasSubstr("degrees instead of rad")));
}

// A pose every four seconds: as milliseconds, the joint would make hundreds of radians a second.
TEST(Suspicions, PosesSecondsApartAreNoMilliseconds) {
  const auto write = [](std::ostream* csv) {
    for (int k = 0; k < 40; ++k) *csv << 4.0 * k << "," << std::sin(1.7 * k) << "," << std::sin(1.7 * k) << "\n";
  };
  const std::string said = load_elbow("poses", "", write);
  EXPECT_THAT(said, testing::HasSubstr("each is a pose at rest"));
  EXPECT_THAT(said, testing::Not(testing::HasSubstr("milliseconds")));
}

TEST(Suspicions, ASlowMotionStampedInMillisecondsIsNoPose) {
  const std::string said = load_elbow("milliseconds", "", [](std::ostream* csv) {
    for (int k = 0; k < 400; ++k)
      *csv << 4.0 * k << "," << std::sin(0.004 * k) << "," << std::sin(0.004 * k - 0.01) << "\n";
  });
  EXPECT_THAT(said, testing::HasSubstr("are these milliseconds?"));
}

TEST(Recordings, AFingerThatNobodyRecordedIsFixedAndTheArmIsJudged) {
  const Experiment e = load_arm_with_finger("shoulder", "elbow");
  EXPECT_EQ(e.num_joints(), 2);
  EXPECT_THAT(e.warnings, testing::Contains(testing::HasSubstr("joint finger is in no recording")));
  ASSERT_EQ(e.recordings.size(), 1u);
  EXPECT_TRUE(e.recordings[0].joints[1].has(Quantity::kPosition));
  EXPECT_NEAR(e.robot.tree.links[2].inertia.mass, 2.0, 1e-12);  // with the finger's
}

TEST(Recordings, AJointBeforeOneThatMovesIsNotFixedAndAMisspeltOneIsRefused) {
  EXPECT_EQ(load_arm_with_finger("shoulder", "finger").num_joints(), 3);
  try {
    load_arm_with_finger("shoulder", "elbw");
    FAIL() << "a misspelt joint was left out";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("the robot has no joint 'elbw'; did you mean 'elbow'?"));
  }
}

// Published models often have inertias that no body can have. Their masses and joints are worth judging all the same.
TEST(Recordings, AModelWithAnImpossibleInertiaIsRepairedAndSaidUnlessItsUserForbidsIt) {
  const Experiment e = load_arm_with_finger("shoulder", "finger", 0.03);
  EXPECT_THAT(e.warnings, testing::Contains(testing::HasSubstr("breaks the triangle inequality")).Times(3));
  EXPECT_TRUE(parse_scenario(e.scenario.text, e.path).repair_inertias) << "what the diagnosis writes must run";
  EXPECT_THROW(load_arm_with_finger("shoulder", "finger", 0.03, "repair_inertias: false\n"), InputError);
}

// A log of the whole machine, a model of its arm: what the model does not have is left out, and said.
TEST(Recordings, JointsThatTheModelDoesNotHaveAreLeftOut) {
  const Experiment e = load_arm_with_finger("shoulder", "rail_carriage");
  EXPECT_THAT(e.warnings, testing::Contains(
                              testing::HasSubstr("joints that the model does not have were left out: rail_carriage")));
}

}  // namespace
}  // namespace hrp::diagnosis
