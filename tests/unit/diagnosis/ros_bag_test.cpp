// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/diagnostics.h"
#include "common/log/ros_bag.h"
#include "diagnosis/data/recording.h"
#include "tests/catch_complaint.h"
#include "tests/unit/diagnosis/bag_writer.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

using namespace testing_bags;
namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr int64_t kEpoch = 1'700'000'000'000'000'000;        // [ns]
const std::vector<std::string> kNames{"elbow", "shoulder"};  // another order than the model's

double shoulder_at(double t) { return 0.5 * std::sin(2.0 * t); }

// Delay of a message [ns]: now and then a tenth of a millisecond, mostly some.
int64_t latency(int k) { return 100'000 + (k % 7) * 250'000; }

// 5 s of joint states at 200 Hz and commands at 100 Hz; `gap`: the states are silent from 2 to 3 s.
std::vector<Message> make_motion(bool gap) {
  std::vector<Message> messages;
  for (int k = 0; k < 1000; ++k) {
    const double t = 0.005 * k;
    const int64_t stamp = kEpoch + int64_t{5'000'000} * k;
    if (!gap || t < 2.0 || t > 3.0)
      messages.push_back(
          {"/joint_states", stamp + latency(k),
           make_joint_state(stamp, kNames, {0.1, shoulder_at(t)}, {0.0, std::cos(2.0 * t)}, {1.0, 2.0 + t})});
    if (k % 2 == 0)
      messages.push_back(
          {"/controller/commands", stamp + 50'000,
           CdrWriter().put(uint32_t{0}).put(uint32_t{0}).put(std::vector<double>{shoulder_at(t), 0.1}).bytes()});
  }
  return messages;
}

const std::vector<Topic> kTopics{{"/joint_states", "sensor_msgs/msg/JointState", kJointStateDefinition},
                                 {"/controller/commands", "std_msgs/msg/Float64MultiArray", ""},
                                 {"/imu/data", "sensor_msgs/msg/Imu", ""},
                                 {"/link_states", "sensor_msgs/msg/JointState", kJointStateDefinition}};
constexpr const char* kMap =
    "topics:\n  joint_states: /joint_states\n  joint_commands: {topic: /controller/commands, joints: [shoulder, "
    "elbow]}\n";

Experiment load(const std::string& name, Storage storage, const std::vector<Message>& messages, const std::string& map,
                const std::string& more = "") {
  const fs::path folder = fs::temp_directory_path() / ("hrp_bag_test_" + name);
  fs::create_directories(folder);
  write_bag(folder / "motion", storage, kTopics, messages);
  std::ofstream(folder / "robot.urdf") << kArm;
  std::ofstream(folder / "experiment.yaml") << "robot: robot.urdf\nbase: fixed\nservo: {default: {kp: 200, kd: 10}}\n"
                                            << "recordings:\n  - {file: motion, role: train}\n"
                                            << map << more;
  return load_experiment((folder / "experiment.yaml").string());
}

std::string find_error(const std::string& name, const std::string& map, const std::vector<Message>& messages) {
  return catch_complaint([&] { load(name, Storage::kMcap, messages, map); });
}

class RosBagStorage : public testing::TestWithParam<Storage> {};

TEST_P(RosBagStorage, GivesEachJointItsOwnReadingsAndTheCommandThatHeld) {
  const Experiment e =
      load("storage" + std::to_string(static_cast<int>(GetParam())), GetParam(), make_motion(false), kMap);
  ASSERT_EQ(e.recordings.size(), 1u);
  const Recording& r = e.recordings[0];
  ASSERT_EQ(r.size(), 1000u);
  for (size_t k = 0; k < r.size(); k += 37) {
    const double t = 0.005 * static_cast<double>(k);
    EXPECT_NEAR(r.time[k] - r.time[0], t, 1e-6);  // stamps are in nanoseconds, times of a bag in microseconds
    EXPECT_DOUBLE_EQ(r.joints[kShoulder].signal[0][k], shoulder_at(t));
    EXPECT_DOUBLE_EQ(r.joints[kShoulder].signal[2][k], 2.0 + t);
    EXPECT_DOUBLE_EQ(r.joints[kElbow].signal[0][k], 0.1);
    // Commands of 100 Hz are held over two rows.
    EXPECT_DOUBLE_EQ(r.joints[kShoulder].command[k], shoulder_at(0.01 * std::floor(static_cast<double>(k) / 2.0)));
  }
}
INSTANTIATE_TEST_SUITE_P(All, RosBagStorage,
                         testing::Values(Storage::kMcap, Storage::kMcapLz4, Storage::kMcapPlain, Storage::kSqlite,
                                         Storage::kSqliteFileZstd, Storage::kSqliteMessageZstd));

// Simulated time, or the uptime of a microcontroller. The first message may come before the first clock.
TEST(RosBag, StampsMayCountFromZero) {
  std::vector<Message> messages{
      {"/joint_states", kEpoch, make_joint_state(0, kNames, {0.1, 0.0}, {0.0, 0.0}, {1.0, 2.0})}};
  for (int k = 0; k < 600; ++k) {
    const int64_t stamp = 100'000'000 + int64_t{5'000'000} * k;
    const double t = 0.005 * k;
    messages.push_back({"/joint_states", kEpoch + stamp,
                        make_joint_state(stamp, kNames, {0.1, shoulder_at(t)}, {0.0, 0.0}, {1.0, 2.0})});
    messages.push_back(
        {"/controller/commands", kEpoch + stamp - 50'000,
         CdrWriter().put(uint32_t{0}).put(uint32_t{0}).put(std::vector<double>{shoulder_at(t), 0.1}).bytes()});
  }
  const Experiment e = load("uptime", Storage::kMcap, messages, kMap);
  ASSERT_EQ(e.recordings.size(), 1u);
  const Recording& r = e.recordings[0];
  ASSERT_EQ(r.size(), 600u);
  for (size_t k = 0; k < r.size(); k += 37) {
    EXPECT_NEAR(r.time[k] - r.time[0], 0.005 * static_cast<double>(k), 1e-6) << k;
    EXPECT_DOUBLE_EQ(r.joints[kShoulder].signal[0][k], shoulder_at(0.005 * static_cast<double>(k))) << k;
  }
}

TEST(RosBag, CarriesNothingAcrossAGap) {
  const Experiment e = load("gap", Storage::kMcap, make_motion(true), kMap);
  ASSERT_EQ(e.recordings.size(), 2u);
  for (const Recording& r : e.recordings) {
    for (size_t k = 1; k < r.size(); ++k) EXPECT_LT(r.time[k] - r.time[k - 1], 0.0051);
  }
  EXPECT_THAT(testing::PrintToString(e.warnings), HasSubstr("/joint_states is silent from"));
}

// An IMU whose clock is 3.2 s ahead and gains 1000 us in a second, over 5 s.
TEST(RosBag, FindsOffsetAndDriftOfATopicsClockAndMovesItsSamples) {
  std::vector<Message> messages = make_motion(false);
  for (int k = 0; k < 2000; ++k) {
    const double t = 0.0025 * k;
    const int64_t taken = kEpoch + int64_t{2'500'000} * k;
    const int64_t stamp = taken + int64_t{3'200'000'000} + static_cast<int64_t>(1e-3 * 1e9 * t);
    messages.push_back({"/imu/data", taken + latency(k),
                        CdrWriter()
                            .header(stamp)
                            .put(0.0)
                            .put(0.0)
                            .put(0.0)
                            .put(1.0)
                            .zeros(9)
                            .put(std::sin(3.0 * t))
                            .put(0.0)
                            .put(0.0)
                            .zeros(9)
                            .put(0.0)
                            .put(0.0)
                            .put(9.81)
                            .zeros(9)
                            .bytes()});
  }
  const Experiment e = load("clock", Storage::kMcap, messages, std::string(kMap) + "  imu/hand: /imu/data\n",
                            "sensors: {imu: {hand: {link: fore}}}\n");
  const Recording& r = e.recordings.at(0);
  const std::vector<double>& rate = r.other.at("/imu/hand/angular_velocity/x");
  for (size_t k = 20; k + 20 < r.size(); k += 50) {
    // Both clocks are known to the fastest messages of a piece: a tenth of a millisecond, times 3 rad/s^2.
    EXPECT_NEAR(rate[k], std::sin(3.0 * (r.time[k] - r.time[0])), 0.001);
  }
  const std::string notes = testing::PrintToString(e.warnings);
  EXPECT_THAT(notes, HasSubstr("its clock is 3.2 s ahead of that of /joint_states"));
  EXPECT_THAT(notes, testing::ContainsRegex("gains (9[89][0-9]|100[0-9]|1e\\+03)"));
}

TEST(RosBag, PutsForceSensorsAndOdometryWhereTheirAxesBelong) {
  std::vector<Message> messages = make_motion(false);
  for (int k = 0; k < 1000; ++k) {
    const int64_t stamp = kEpoch + int64_t{5'000'000} * k;
    CdrWriter wrench, odometry;
    wrench.header(stamp).put(1.0).put(2.0).put(3.0).put(4.0).put(5.0).put(6.0);
    odometry.header(stamp)
        .put(std::string("child"))
        .put(0.1)
        .put(0.2)
        .put(0.3)
        .put(0.0)
        .put(0.0)
        .put(0.6)
        .put(0.8)
        .zeros(36);
    odometry.zeros(6 + 36);
    messages.push_back({"/ft", stamp, wrench.bytes()});
    messages.push_back({"/odom", stamp, odometry.bytes()});
  }
  const fs::path folder = fs::temp_directory_path() / "hrp_bag_test_axes";
  fs::create_directories(folder);
  std::vector<Topic> topics = kTopics;
  topics.push_back({"/ft", "geometry_msgs/msg/WrenchStamped", ""});
  topics.push_back({"/odom", "nav_msgs/msg/Odometry", ""});
  write_bag(folder / "motion", Storage::kSqlite, topics, messages);
  std::ofstream(folder / "robot.urdf") << kArm;
  std::ofstream(folder / "experiment.yaml")
      << "robot: robot.urdf\nbase: fixed\ndrive: effort\nrecordings: [{file: motion}]\n"
      << "sensors: {wrench: {hand: {link: fore}}}\ntopics:\n  joint_states: /joint_states\n"
      << "  wrench/hand: /ft\n  base: /odom\n";
  const Experiment e = load_experiment((folder / "experiment.yaml").string());
  const Recording& r = e.recordings.at(0);
  EXPECT_EQ(r.other.at("/wrench/hand/force/z")[100], 3.0);
  EXPECT_EQ(r.other.at("/wrench/hand/torque/x")[100], 4.0);
  EXPECT_EQ(r.other.at("/base/pose/position/y")[100], 0.2);
  EXPECT_EQ(r.other.at("/base/pose/orientation/w")[100], 0.8);
}

TEST(RosBag, EncodersAndTorquesBehindTheGearsComeFromATopicOfTheirOwn) {
  std::vector<Message> messages = make_motion(false);
  for (int k = 0; k < 1000; ++k) {
    const int64_t stamp = kEpoch + int64_t{5'000'000} * k;
    messages.push_back(
        {"/link_states", stamp + latency(k), make_joint_state(stamp, kNames, {0.2, 0.3}, {0.0, 0.0}, {1.5, 2.5})});
  }
  const Experiment e =
      load("link_side", Storage::kMcap, messages, std::string(kMap) + "  joint_states_link: /link_states\n",
           "sensors: {joint_torque: [shoulder, elbow], link_encoder: [elbow]}\n");
  const Recording& r = e.recordings.at(0);
  EXPECT_DOUBLE_EQ(r.other.at("/joint_states_link/elbow/effort")[500], 1.5);
  EXPECT_DOUBLE_EQ(r.other.at("/joint_states_link/shoulder/effort")[500], 2.5);
  EXPECT_DOUBLE_EQ(r.other.at("/joint_states_link/elbow/position")[500], 0.2);
}

TEST(RosBag, IsReadWithoutAMapWhereNamesAndTypesSayEnough) {
  std::vector<Message> messages;
  for (const Message& m : make_motion(false)) {
    if (m.topic == "/joint_states") messages.push_back(m);
  }
  const Experiment e = load("guess", Storage::kSqlite, messages, "drive: effort\n");
  EXPECT_EQ(e.recordings.at(0).size(), 1000u);
  EXPECT_THAT(testing::PrintToString(e.warnings), HasSubstr("topic /joint_states was taken as joint_states"));
}

TEST(RosBag, AFileThatTheSystemCannotLookForIsNotThere) {
  const fs::path folder = fs::temp_directory_path() / "hrp_bag_test_long_name";
  fs::create_directories(folder);
  std::ofstream(folder / "metadata.yaml") << "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n"
                                          << "  relative_file_paths: [" << std::string(300, 'a') << "]\n";
  EXPECT_THROW(RosBag(folder.string()), InputError);
  EXPECT_FALSE(is_ros_bag(std::string(300, 'a')));
}

TEST(RosBag, SaysWhichTopicItHasInstead) {
  const std::string text = find_error("topic", "topics:\n  joint_states: /joint_state\n", make_motion(false));
  EXPECT_THAT(text, HasSubstr("experiment.yaml:7:"));
  EXPECT_THAT(text, HasSubstr("did you mean '/joint_states'"));
}

TEST(RosBag, SaysThatAListOfNumbersNeedsNamesOfJoints) {
  const std::string text = find_error("names", "topics:\n  joint_commands: /controller/commands\n", make_motion(false));
  EXPECT_THAT(text, HasSubstr("topics.joint_commands.joints"));
  EXPECT_THAT(text, HasSubstr("std_msgs/msg/Float64MultiArray"));
}

TEST(RosBag, SaysWhichFieldHasTooFewElements) {
  std::vector<Message> messages = make_motion(false);
  messages.push_back(
      {"/joint_states", kEpoch + 6'000'000'000, make_joint_state(kEpoch + 6'000'000'000, kNames, {0.1}, {}, {})});
  const std::string text = find_error("few", kMap, messages);
  EXPECT_THAT(text, HasSubstr("/joint_states"));
  EXPECT_THAT(text, HasSubstr("field 'position' has 1 elements, expected 2"));
}

// A message type of a robot's maker, which the bag defines: joints by position, readings under names of their own.
TEST(RosBag, ReadsATypeOfItsOwnByStatedFields) {
  const fs::path folder = fs::temp_directory_path() / "hrp_bag_test_own";
  fs::create_directories(folder);
  std::vector<Message> messages;
  for (int k = 0; k < 400; ++k) {
    CdrWriter out;
    out.put(uint8_t{3}).put(uint32_t{2});
    for (int j = 0; j < 2; ++j) out.put(uint8_t{1}).put(static_cast<float>(0.01 * k + j)).put(2.0f);
    messages.push_back({"/lowstate", kEpoch + int64_t{5'000'000} * k, out.bytes()});
  }
  const std::string definition =
      "uint8 level\nuint8 LEVEL_HIGH=3\nMotor[] motor\n====\nMSG: maker_msgs/Motor\nuint8 mode\nfloat32 q\nfloat32 "
      "tau\n";
  write_bag(folder / "motion", Storage::kMcap, {{"/lowstate", "maker_msgs/msg/State", definition}}, messages);
  std::ofstream(folder / "robot.urdf") << kArm;
  std::ofstream(folder / "experiment.yaml")
      << "robot: robot.urdf\nbase: fixed\ndrive: effort\nrecordings: [{file: motion}]\ntopics:\n  joint_states:\n    "
         "topic: "
         "/lowstate\n    joints: [shoulder, elbow]\n    fields: {position: 'motor[].q', effort: 'motor[].tau'}\n";
  const Experiment e = load_experiment((folder / "experiment.yaml").string());
  EXPECT_NEAR(e.recordings.at(0).joints[kElbow].signal[0][100], 2.0, 1e-6);  // of a float
}

}  // namespace
}  // namespace hrp::diagnosis
