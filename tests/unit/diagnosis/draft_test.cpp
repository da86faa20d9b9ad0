// SPDX-License-Identifier: BSD-3-Clause
// Which columns of other people's logs are which signals, by their names and numbers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "common/base/diagnostics.h"
#include "diagnosis/data/recording.h"
#include "diagnosis/draft/column_names.h"
#include "diagnosis/draft/column_relations.h"
#include "diagnosis/draft/draft.h"
#include "diagnosis/draft/imu_columns.h"
#include "tests/catch_complaint.h"
#include "tests/unit/diagnosis/bag_writer.h"

namespace hrp::diagnosis {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const std::vector<std::string> kLeg{"hip_joint", "knee_joint"};

struct Reading {
  const char* name;
  ColumnKind kind;
  bool command;
  int joint, index;
  double scale;
};

TEST(ColumnNames, AreReadAsPeopleWriteThem) {
  using Q = ColumnKind;
  for (const Reading& r : {Reading{"hip_pos", Q::kPosition, false, 0, -1, 0.0},
                           {"knee_joint/velocity", Q::kVelocity, false, 1, -1, 0.0},
                           {"tau_J[1]", Q::kEffort, false, -1, 1, 0.0},
                           {"q_d3", Q::kPosition, true, -1, 3, 0.0},
                           {"dq_0", Q::kVelocity, false, -1, 0, 0.0},
                           {"motorTorque_2", Q::kEffort, false, -1, 2, 0.0},
                           {"target_q_4", Q::kPosition, true, -1, 4, 0.0},
                           {"qDot1", Q::kVelocity, false, -1, 1, 0.0},
                           {"Knee Angle (deg)", Q::kPosition, false, 1, -1, M_PI / 180},
                           {"timestamp_ms", Q::kTime, false, -1, -1, 1e-3},
                           {"Time", Q::kTime, false, -1, -1, 0.0},
                           {"nsecs", Q::kNone, false, -1, -1, 0.0},
                           {"qdd_1", Q::kNone, false, -1, 1, 0.0},
                           {"hip_temperature", Q::kNone, false, 0, -1, 0.0},
                           {"position_error_1", Q::kNone, false, -1, 1, 0.0},
                           {"Iq", Q::kEffort, false, -1, -1, 0.0},
                           {"hip_iq_ref", Q::kEffort, true, 0, -1, 0.0},
                           {"motor_amps", Q::kEffort, false, -1, -1, 0.0},
                           {"hip_rpm", Q::kVelocity, false, 0, -1, M_PI / 30},
                           {"vel_knee_degps", Q::kVelocity, false, 1, -1, M_PI / 180},
                           {"pwm_cmd", Q::kEffort, false, -1, -1, 0.0},
                           {"Output Voltage (V)", Q::kEffort, false, -1, -1, 0.0},
                           {"cmd_hip", Q::kPosition, true, 0, -1, 0.0},
                           {"meas_knee_deg", Q::kPosition, false, 1, -1, M_PI / 180},
                           {"knee_torque_mNm", Q::kEffort, false, 1, -1, 1e-3},
                           {"hip current (mA)", Q::kEffort, false, 0, -1, 1e-3},
                           {"pwm_mV_3", Q::kEffort, false, -1, 3, 1e-3},
                           {"eff_hip", Q::kEffort, false, 0, -1, 0.0},
                           {"hip_action", Q::kNone, true, 0, -1, 0.0},
                           {"hip_torque_enable", Q::kNone, false, 0, -1, 0.0},
                           {"position_p_gain_1", Q::kNone, false, -1, 1, 0.0},
                           {"battery_voltage", Q::kNone, false, -1, -1, 0.0}}) {
    const ColumnMeaning m = find_meaning(r.name, kLeg);
    EXPECT_EQ(m.kind, r.kind) << r.name;
    EXPECT_EQ(m.command, r.command) << r.name;
    EXPECT_EQ(m.joint, r.joint) << r.name;
    EXPECT_EQ(m.index, r.index) << r.name;
    EXPECT_NEAR(m.scale, r.scale, 1e-12) << r.name;
  }
}

TEST(ColumnRelations, AClockThatCountsFrom1970TellsItsUnitAtAnyRate) {
  EXPECT_EQ(find_time_scale(2e5, 1.7e18), 1e-9) << "5 kHz in nanoseconds, or 5 Hz in microseconds";
  EXPECT_EQ(find_time_scale(200.0, 1.7e15), 1e-6);
  EXPECT_EQ(find_time_scale(0.2, 1.7e12), 1e-3);
  EXPECT_EQ(find_time_scale(5.0, 0.0), 1e-3);
  EXPECT_EQ(find_time_scale(0.005, 1.7e9), 1.0);
}

TEST(ColumnNames, OfDrivesSayThatTheyAreNoTorques) {
  for (const auto& [name, of] :
       std::vector<std::pair<const char*, EffortOf>>{{"hip_pwm", EffortOf::kDuty},
                                                     {"knee duty cycle", EffortOf::kDuty},
                                                     {"present_load_1", EffortOf::kDuty},
                                                     {"hip voltage [V]", EffortOf::kVoltage},
                                                     {"Iq", EffortOf::kCurrent},
                                                     {"hip_current_mA", EffortOf::kCurrent},
                                                     {"current_torque_1", EffortOf::kTorque}}) {
    EXPECT_EQ(find_meaning(name, kLeg).kind, ColumnKind::kEffort) << name;
    EXPECT_EQ(find_meaning(name, kLeg).of, of) << name;
  }
  EXPECT_EQ(find_meaning("current_position_1", kLeg).kind, ColumnKind::kPosition);
  EXPECT_EQ(find_meaning("battery_voltage", kLeg).kind, ColumnKind::kNone);
}

TEST(ColumnNames, NumbersCountTheJointsFromZeroOrOne) {
  for (const std::vector<std::string>& names : {std::vector<std::string>{"q0", "q1"}, {"q1", "q2"}}) {
    const auto meanings = find_meanings(names, kLeg);
    EXPECT_EQ(meanings[0].joint, 0) << names[0];
    EXPECT_EQ(meanings[1].joint, 1) << names[0];
  }
  // Of three columns for two joints nobody knows which ones are meant.
  for (const ColumnMeaning& m : find_meanings({"q0", "q1", "q2"}, kLeg)) EXPECT_EQ(m.joint, -1);
  EXPECT_EQ(find_meanings({"angle"}, {"pendulum"})[0].joint, 0);
}

TEST(ColumnNames, AJointsNameAloneIsItsPosition) {
  const ColumnMeaning knee = find_meaning("knee", kLeg), load = find_meaning("knee_temperature", kLeg);
  EXPECT_EQ(knee.kind, ColumnKind::kPosition);
  EXPECT_EQ(knee.joint, 1);
  EXPECT_EQ(load.kind, ColumnKind::kNone);
}

TEST(ColumnNames, ThatAreShortForAllJointsTellThem) {
  const std::vector<std::string> joints{"fl_shoulder_joint", "fl_thigh_joint", "fr_shoulder_joint", "fr_thigh_joint"};
  const std::vector<ColumnMeaning> m = find_meanings(
      {"pos_fl_sh", "pos_fl_th", "pos_fr_sh", "pos_fr_th", "load_fr_th", "cmd_pos_fl_th", "cmd_pos_fl_sh"}, joints);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(m[static_cast<size_t>(i)].joint, i);
  EXPECT_EQ(m[4].joint, -1) << "a single one may fit by chance";
  EXPECT_EQ(m[5].joint, 1);
  EXPECT_EQ(m[6].joint, 0);
  // A letter that begins two names tells neither, and then the others may be of other joints, too.
  const std::vector<ColumnMeaning> unclear =
      find_meanings({"pos_fl_s", "pos_fl_t"}, {"fl_shoulder", "fl_shin", "fl_thigh"});
  EXPECT_EQ(unclear[0].joint, -1);
  EXPECT_EQ(unclear[1].joint, -1);
}

TEST(ColumnNames, TheLongestNameOfAJointCounts) {
  const std::vector<std::string> joints{"hip_yaw", "left_hip_yaw"};
  EXPECT_EQ(find_meaning("left_hip_yaw_pos", joints).joint, 1);
  EXPECT_EQ(find_meaning("hip_yaw_pos", joints).joint, 0);
}

class Drafts : public ::testing::Test {
 protected:
  Drafts() : folder_(std::filesystem::temp_directory_path() / ("draft_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
    write(
        "arm.urdf",
        "<robot name=\"arm\"><link name=\"base\"/>"
        "<link name=\"upper\"><inertial><origin xyz=\"0 0 -0.1\"/><mass value=\"1\"/><inertia ixx=\"0.01\" "
        "iyy=\"0.01\" izz=\"0.01\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>"
        "<joint name=\"shoulder\" type=\"revolute\"><parent link=\"base\"/><child link=\"upper\"/><axis xyz=\"0 1 0\"/>"
        "<limit lower=\"-3\" upper=\"3\" effort=\"10\" velocity=\"10\"/></joint></robot>");
  }
  ~Drafts() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }

  // Rows of time, position, velocity, torque at 100 Hz; stamps in milliseconds.
  std::string make_rows(const std::string& separator) const {
    std::string rows;
    for (int k = 0; k < 300; ++k) {
      const double t = 0.01 * k, q = std::sin(3 * t) + 0.3 * std::sin(7 * t),
                   v = 3 * std::cos(3 * t) + 2.1 * std::cos(7 * t);
      rows += std::to_string(1e4 + 10.0 * k) + separator + std::to_string(q) + separator + std::to_string(v) +
              separator + std::to_string(0.98 * std::sin(q)) + "\n";
    }
    return rows;
  }

  std::filesystem::path folder_;
};

TEST_F(Drafts, AreExperimentsThatTheToolReads) {
  for (const char* name : {"one.csv", "two.csv"})
    write(name, "stamp;shoulder angle;shoulder velocity;shoulder torque\n" + make_rows(";"));
  const Draft draft = make_draft(path("arm.urdf"), {path("one.csv"), path("two.csv")}, folder_.string());
  write("experiment.yaml", draft.text);
  EXPECT_THAT(draft.asked, ::testing::IsEmpty()) << draft.text;
  const Experiment experiment = load_experiment(path("experiment.yaml"));
  ASSERT_EQ(experiment.recordings.size(), 2u);
  EXPECT_NEAR(experiment.recordings[0].time.back() - experiment.recordings[0].time.front(), 2.99, 1e-9) << draft.text;
}

TEST_F(Drafts, OfCurrentsAskForTheTorqueConstant) {
  for (const auto& [column, asked] :
       std::vector<std::pair<std::string, std::string>>{{"current", "torque constant at the joint [N m/A]"},
                                                        {"pwm", "stall torque over the largest count"},
                                                        {"voltage", "[N m/V]"}}) {
    write("log.csv", "stamp;shoulder angle;shoulder velocity;shoulder " + column + "\n" + make_rows(";"));
    const Draft draft = make_draft(path("arm.urdf"), {path("log.csv")}, folder_.string());
    EXPECT_THAT(testing::PrintToString(draft.asked), HasSubstr(asked));
    EXPECT_THAT(draft.text,
                HasSubstr("/joint_states/shoulder/effort: {column: 'shoulder " + column + "', scale: 1}   # (?)"));
  }
  // A column of torques is closer to a torque.
  write("log.csv", "shoulder torque;shoulder angle;shoulder current;shoulder pwm\n" + make_rows(";"));
  const Draft draft = make_draft(path("arm.urdf"), {path("log.csv")}, folder_.string());
  EXPECT_THAT(draft.text, HasSubstr("/joint_states/shoulder/effort: 'shoulder torque'"));
  EXPECT_THAT(testing::PrintToString(draft.asked), Not(HasSubstr("torque constant")));
}

TEST_F(Drafts, OfFilesWithAnyNamesAreRead) {
  const std::vector<std::string> names{"run #1, fast.csv", "it's {one}: a.csv", "&log.csv"};
  std::vector<std::string> logs;
  for (const std::string& name : names) {
    write(name, "stamp;shoulder angle;shoulder velocity;shoulder current\n" + make_rows(";"));
    logs.push_back(path(name));
  }
  write("experiment.yaml", make_draft(path("arm.urdf"), logs, folder_.string()).text);
  const Experiment experiment = load_experiment(path("experiment.yaml"));
  ASSERT_EQ(experiment.recordings.size(), names.size());
  for (size_t i = 0; i < names.size(); ++i) EXPECT_EQ(experiment.recordings[i].spec.name, names[i]);
}

// In Latin-1, with a star, twice in the header.
TEST_F(Drafts, OfColumnsWithAnyNamesAreRead) {
  for (const char* angle : {"shoulder angle [\xb0]", "shoulder angle*", "it's the shoulder: angle #1"}) {
    write("log.csv", std::string("stamp;") + angle + ";shoulder velocity;shoulder torque\n" + make_rows(";"));
    write("experiment.yaml", make_draft(path("arm.urdf"), {path("log.csv")}, folder_.string()).text);
    const Experiment experiment = load_experiment(path("experiment.yaml"));
    EXPECT_NEAR(experiment.recordings[0].joints[0].signal[static_cast<int>(Quantity::kPosition)][50],
                std::sin(1.5) + 0.3 * std::sin(3.5), 1e-6)
        << angle;
  }
  write("log.csv", "stamp;shoulder angle;shoulder angle;shoulder torque\n" + make_rows(";"));
  EXPECT_THAT(make_draft(path("arm.urdf"), {path("log.csv")}, folder_.string()).text,
              HasSubstr("/joint_states/shoulder/position: 2\n"));
}

TEST_F(Drafts, OfJointsWithAnyNamesAreRead) {
  std::ifstream file(path("arm.urdf"));
  std::string urdf{std::istreambuf_iterator<char>(file), {}};
  urdf.replace(urdf.find("shoulder"), 8, "shoulder: left #1");
  write("odd.urdf", urdf);
  write("log.csv", "stamp;shoulder left 1 angle;shoulder left 1 velocity;shoulder left 1 torque\n" + make_rows(";"));
  write("experiment.yaml", make_draft(path("odd.urdf"), {path("log.csv")}, folder_.string()).text);
  EXPECT_EQ(load_experiment(path("experiment.yaml"))
                .recordings[0]
                .joints[0]
                .signal[static_cast<int>(Quantity::kEffort)]
                .size(),
            300u);
}

TEST_F(Drafts, WithoutAHeaderTakePairsOfPositionAndRateAndAsk) {
  write("log.txt", make_rows(" "));
  const Draft draft = make_draft(path("arm.urdf"), {path("log.txt")}, folder_.string());
  EXPECT_THAT(draft.text, HasSubstr("time: {column: 1, scale: 0.001}"));
  EXPECT_THAT(draft.text, HasSubstr("position: 2\n")) << draft.text;
  EXPECT_THAT(draft.text, HasSubstr("velocity: 3\n"));
  EXPECT_THAT(draft.text, HasSubstr("effort: 4\n"));
  EXPECT_EQ(draft.asked.size(), 2u);  // a second log, the columns
}

TEST_F(Drafts, WithoutAHeaderDescribeTheColumnsAndAsk) {
  std::string rows = make_rows(" ");
  for (size_t at = 0; (at = rows.find('\n', at)) != std::string::npos; at += 3) rows.insert(at, " 7");  // what is that?
  write("log.txt", rows);
  const Draft draft = make_draft(path("arm.urdf"), {path("log.txt")}, folder_.string());
  EXPECT_THAT(draft.text, HasSubstr("3: -4.18 to 5.1; the rate of column 2")) << draft.text;
  EXPECT_EQ(draft.asked.size(), 4u);  // a second log, positions, efforts or commands, the columns
}

// A motor with 2400 counts a turn behind its gear, as small controllers log it.
TEST_F(Drafts, CountTheTurnsOfAnEncoderByTheSpeedBesideIt) {
  std::string rows = "t_ms,duty,enc_count,rpm\n";
  for (int k = 0; k < 300; ++k) {
    const double t = 0.01 * k, q = 5.0 * std::sin(3 * t), v = 15.0 * std::cos(3 * t);  // rad, rad/s
    rows += std::to_string(10 * k) + "," + std::to_string(std::lround(100 * std::cos(3 * t))) + "," +
            std::to_string(std::lround(q * 2400 / (2 * M_PI))) + "," + std::to_string(v * 30 / M_PI) + "\n";
  }
  write("motor.csv", rows);
  const Draft draft = make_draft(path("arm.urdf"), {path("motor.csv"), path("motor.csv")}, folder_.string());
  EXPECT_THAT(testing::PrintToString(draft.found), HasSubstr("2400 counts a turn, by column 'rpm'"));
  EXPECT_THAT(draft.text, HasSubstr("/joint_states/shoulder/effort: {column: 'duty', scale: 1}"));
  EXPECT_THAT(testing::PrintToString(draft.asked), HasSubstr("a duty needs the sign"));
  write("experiment.yaml", draft.text);
  const Experiment experiment = load_experiment(path("experiment.yaml"));
  EXPECT_NEAR(experiment.recordings[0].joints[0].signal[static_cast<int>(Quantity::kPosition)][52], 5.0, 0.01)
      << draft.text;
}

// Seconds and their fraction that were read one after the other.
TEST_F(Drafts, OfAClockThatGoesBackSayWhere) {
  write("log.csv", "stamp,angle,current\n11.98,0.1,1\n11.99,0.2,1\n11.00,0.3,1\n12.01,0.4,1\n");
  EXPECT_THAT(testing::PrintToString(make_draft(path("arm.urdf"), {path("log.csv")}, folder_.string()).asked),
              HasSubstr("column 'stamp' goes back from 11.99 to 11, in row 3"));
}

// As a potentiometer behind the gear reads: the limits of the arm are 3 rad.
TEST_F(Drafts, OfAnglesFarBeyondTheLimitsAreInDegreesAndAsk) {
  write("log.csv", "time,angle,current\n0.00,70,1\n0.01,90,1\n0.02,145,1\n");
  const Draft draft = make_draft(path("arm.urdf"), {path("log.csv")}, folder_.string());
  EXPECT_THAT(draft.text, HasSubstr("position: {column: 'angle', scale: 0.0174532925"));
  EXPECT_THAT(testing::PrintToString(draft.asked), HasSubstr("whether column 'angle' is in degrees"));
}

TEST_F(Drafts, AskForTheCountsOfATurnWhereNoSpeedTellsThem) {
  write("motor.csv", "time,encoder_ticks,current\n0.00,0,1\n0.01,5,1\n0.02,20,1\n");
  EXPECT_THAT(testing::PrintToString(make_draft(path("arm.urdf"), {path("motor.csv")}, folder_.string()).asked),
              HasSubstr("how many counts a turn column 'encoder_ticks' has"));
}

TEST_F(Drafts, AVoltageBesideAnEffortIsNotUsed) {
  write("log.csv", "time,q,voltage,current\n0.00,0,12,1\n0.01,5,12,1\n0.02,20,12,1\n");
  EXPECT_THAT(make_draft(path("arm.urdf"), {path("log.csv")}, folder_.string()).text,
              HasSubstr("effort: {column: 'current', scale: 1}"));
}

TEST_F(Drafts, AskWhoseAnEffortIsThatNamesNoneOfTwoJoints) {
  write("two.urdf",
        "<robot name=\"two\"><link name=\"base\"/>"
        "<link name=\"upper\"><inertial><mass value=\"1\"/><inertia ixx=\"0.01\" iyy=\"0.01\" izz=\"0.01\" ixy=\"0\" "
        "ixz=\"0\" iyz=\"0\"/></inertial></link>"
        "<link name=\"lower\"><inertial><mass value=\"1\"/><inertia ixx=\"0.01\" iyy=\"0.01\" izz=\"0.01\" ixy=\"0\" "
        "ixz=\"0\" iyz=\"0\"/></inertial></link>"
        "<joint name=\"arm\" type=\"continuous\"><parent link=\"base\"/><child link=\"upper\"/></joint>"
        "<joint name=\"pendulum\" type=\"continuous\"><parent link=\"upper\"/><child link=\"lower\"/></joint></robot>");
  write("log.csv", "time,arm,pendulum,current\n0.00,0,0,1\n0.01,5,0,1\n0.02,20,0,1\n");
  const Draft draft = make_draft(path("two.urdf"), {path("log.csv")}, folder_.string());
  EXPECT_THAT(draft.text, HasSubstr("/joint_states/pendulum/position: 'pendulum'"));
  EXPECT_THAT(testing::PrintToString(draft.asked),
              HasSubstr("which joint column 'current' belongs to: by its name it is an effort"));
}

TEST_F(Drafts, AskForTheRateWhereThereAreNoStamps) {
  write("log.csv", "shoulder_q,shoulder_tau\n0.1,0.2\n0.2,0.1\n0.1,0.3\n");
  const Draft draft = make_draft(path("arm.urdf"), {path("log.csv")}, folder_.string());
  EXPECT_THAT(draft.text, HasSubstr("sample_rate: 100    # (?)"));
  EXPECT_THAT(draft.text, HasSubstr("/joint_states/shoulder/effort: 'shoulder_tau'"));
}

TEST_F(Drafts, TakeTimesOfDayAsStamps) {
  std::string log = "Timestamp,shoulder_position\n";
  for (int k = 0; k < 50; ++k)
    log += "14:43:24." + std::to_string(110 + 10 * k) + "," + std::to_string(0.01 * k) + "\n";
  write("log.csv", log);
  EXPECT_THAT(make_draft(path("arm.urdf"), {path("log.csv")}, folder_.string()).text,
              HasSubstr("time: {column: 'Timestamp', scale: 1}   # 100 Hz"));
}

TEST_F(Drafts, TakeTheRateFromAVelocityWhereThereAreNoStamps) {
  const std::string rows = make_rows(" ");
  std::string without;
  for (size_t at = 0; at < rows.size(); at = rows.find('\n', at) + 1)
    without += rows.substr(rows.find(' ', at) + 1, rows.find('\n', at) - rows.find(' ', at));
  write("log.txt", without);
  EXPECT_THAT(
      make_draft(path("arm.urdf"), {path("log.txt")}, folder_.string()).text,
      HasSubstr("sample_rate: 100    # (?) [Hz]: no column of time was found; so column 2 is the rate of column 1"));
}

// The first row has words, and its names stand in a comment: it was taken for the header. Joints come in the driver's
// order.
TEST_F(Drafts, OfRostopicEchoTakeTheJointsFromTheirCells) {
  std::string rows =
      "%time,field.header.seq,field.header.frame_id,field.name0,field.name1,field.position0,field.position1,field."
      "effort0,field.effort1\n";
  for (int k = 0; k < 100; ++k) {
    rows += std::to_string(1747657995240000000 + 10000000LL * k) + "," + std::to_string(k) +
            ",base,gripper,shoulder,0," + std::to_string(std::sin(0.05 * k)) + ",0,1.5\n";
  }
  for (const char* name : {"one.csv", "two.csv"}) write(name, rows);
  const Draft draft = make_draft(path("arm.urdf"), {path("one.csv"), path("two.csv")}, folder_.string());
  EXPECT_THAT(draft.asked, ::testing::IsEmpty()) << draft.text;
  EXPECT_THAT(draft.text, HasSubstr("/joint_states/shoulder/effort: 'field.effort1'"));
  write("experiment.yaml", draft.text);
  const Recording recording = load_experiment(path("experiment.yaml")).recordings.at(0);
  EXPECT_EQ(recording.size(), 100u);
  EXPECT_NEAR(recording.time.back() - recording.time.front(), 0.99, 1e-6);
  EXPECT_NEAR(recording.joints[0].signal[static_cast<int>(Quantity::kPosition)][0], 0.0, 1e-9);
  EXPECT_NEAR(recording.joints[0].signal[static_cast<int>(Quantity::kPosition)][50], std::sin(2.5), 1e-6);
}

TEST_F(Drafts, OfABagNameItsTopicsAndSensors) {
  using namespace testing_bags;
  std::vector<Message> messages;
  for (int k = 0; k < 400; ++k) {
    const int64_t stamp = int64_t{5'000'000} * k;
    messages.push_back({"/states", stamp, make_joint_state(stamp, {"shoulder"}, {std::sin(0.02 * k)}, {}, {1.0})});
    messages.push_back(
        {"/imu/data", stamp, CdrWriter().put(int32_t{0}).put(uint32_t{0}).put(std::string("upper")).zeros(37).bytes()});
    messages.push_back(
        {"/imu_data", stamp, CdrWriter().put(int32_t{0}).put(uint32_t{0}).put(std::string("upper")).zeros(37).bytes()});
    messages.push_back(
        {"/tool", stamp, CdrWriter().put(int32_t{0}).put(uint32_t{0}).put(std::string("flange")).zeros(6).bytes()});
    messages.push_back({"/controller/commands", stamp,
                        CdrWriter().put(uint32_t{0}).put(uint32_t{0}).put(std::vector<double>{0.1}).bytes()});
  }
  write_bag(folder_ / "motion", Storage::kMcap,
            {{"/states", "sensor_msgs/msg/JointState", kJointStateDefinition},
             {"/imu/data", "sensor_msgs/msg/Imu", ""},
             {"/imu_data", "sensor_msgs/msg/Imu", ""},
             {"/tool", "geometry_msgs/msg/WrenchStamped", ""},
             {"/controller/commands", "std_msgs/msg/Float64MultiArray", ""}},
            messages);
  const Draft draft = make_draft(path("arm.urdf"), {path("motion")}, folder_.string());
  write("experiment.yaml", draft.text);
  EXPECT_THAT(draft.found,
              ::testing::Contains("topic /states: 1 of 1 joints; positions: yes, velocities: no, efforts: yes"));
  EXPECT_THAT(draft.text, HasSubstr("imu_data: {link: upper}"));
  EXPECT_THAT(testing::PrintToString(draft.asked), HasSubstr("the model has no 'flange'"));
  EXPECT_THAT(testing::PrintToString(draft.asked), HasSubstr("the numbers of /controller/commands"));
  const Experiment experiment = load_experiment(path("experiment.yaml"));
  ASSERT_EQ(experiment.recordings.size(), 1u) << draft.text;
  EXPECT_TRUE(experiment.recordings[0].has("/imu/imu_data/linear_acceleration/x"));
  EXPECT_TRUE(experiment.recordings[0].has("/imu/imu_data_2/linear_acceleration/x")) << "a name of its own";
  EXPECT_TRUE(experiment.recordings[0].has("/wrench/tool/force/z"));
}

TEST(ImuColumns, AreReadAsPeopleWriteThem) {
  for (const std::vector<std::string>& names :
       {std::vector<std::string>{"imu_gyro_x", "imu_gyro_y", "imu_gyro_z", "imu_accel_x", "imu_accel_y", "imu_accel_z"},
        {"base_ang_vel_x", "base_ang_vel_y", "base_ang_vel_z", "base_lin_acc_x", "base_lin_acc_y", "base_lin_acc_z"},
        {"/imu/angular_velocity.x", "/imu/angular_velocity.y", "/imu/angular_velocity.z", "linear_acceleration.x",
         "linear_acceleration.y", "linear_acceleration.z"},
        {"BaseWx", "BaseWy", "BaseWz", "BaseAx", "BaseAy", "BaseAz"},
        {"gx", "gy", "gz", "ax", "ay", "az"},
        {"GyrX", "GyrY", "GyrZ", "AccX [m/s^2]", "AccY [m/s^2]", "AccZ [m/s^2]"}}) {
    const std::vector<ImuColumn> found = find_imu_columns(names);
    ASSERT_EQ(found.size(), 6u) << names[0];
    EXPECT_EQ(found[0].signal, "angular_velocity/x") << names[0];
    EXPECT_EQ(found[5].signal, "linear_acceleration/z") << names[0];
    EXPECT_EQ(found[5].column, 5u) << names[0];
  }
  // A turn alone may be that of a camera's pose; two axes of three are no sensor; a speed along a line is none either.
  EXPECT_TRUE(find_imu_columns(
                  {"quat_w", "quat_x", "quat_y", "quat_z", "gyro_x", "gyro_y", "lin_vel_x", "lin_vel_y", "lin_vel_z"})
                  .empty());
}

TEST_F(Drafts, OfARobotWithAnInertialSensorOnItsBodyFloat) {
  write("leg.urdf",
        "<robot name=\"leg\"><link name=\"trunk\"><inertial><mass value=\"5\"/><inertia ixx=\"0.1\" iyy=\"0.1\" "
        "izz=\"0.1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>"
        "<link name=\"shin\"><inertial><mass value=\"1\"/><inertia ixx=\"0.01\" iyy=\"0.01\" izz=\"0.01\" ixy=\"0\" "
        "ixz=\"0\" iyz=\"0\"/></inertial></link>"
        "<joint name=\"knee\" type=\"revolute\"><parent link=\"trunk\"/><child link=\"shin\"/><axis xyz=\"0 1 "
        "0\"/><limit lower=\"-3\" upper=\"3\" effort=\"10\" velocity=\"10\"/></joint></robot>");
  std::string rows = "time,knee_pos,knee_torque,gyro_x,gyro_y,gyro_z,acc_x,acc_y,acc_z\n";
  for (int k = 0; k < 300; ++k)
    rows += std::to_string(0.01 * k) + "," + std::to_string(std::sin(0.03 * k)) + ",1,0,0,0,0,0,9.8" +
            std::to_string(k % 3) + "\n";
  write("log.csv", rows);
  const Draft draft = make_draft(path("leg.urdf"), {path("log.csv")}, folder_.string());
  EXPECT_THAT(draft.text, HasSubstr("base: floating"));
  EXPECT_THAT(testing::PrintToString(draft.asked), HasSubstr("which links of the model are its feet"));
  write("experiment.yaml", draft.text);
  EXPECT_TRUE(load_experiment(path("experiment.yaml")).recordings[0].has("/imu/body/linear_acceleration/z"))
      << draft.text;
  // The root of this one has no mass: it is the world.
  write("arm.csv", "time,shoulder_pos,shoulder_torque,gyro_x,gyro_y,gyro_z,acc_x,acc_y,acc_z\n" +
                       rows.substr(rows.find('\n') + 1));
  EXPECT_THAT(make_draft(path("arm.urdf"), {path("arm.csv")}, folder_.string()).text, HasSubstr("base: fixed"));
}

// As a quadruped logs its gait: no torques, one force a foot.
TEST_F(Drafts, OfForcesUnderFeetNameTheFeet) {
  const std::string mass =
      "<inertial><mass value=\"1\"/><inertia ixx=\"0.1\" iyy=\"0.1\" izz=\"0.1\" ixy=\"0\" ixz=\"0\" "
      "iyz=\"0\"/></inertial></link>";
  std::string urdf = "<robot name=\"biped\"><link name=\"trunk\">" + mass;
  for (const std::string side : {"left", "right"}) {
    urdf += "<link name=\"" + side + "_shin\">" + mass + "<link name=\"" + side + "_foot\">" + mass + "<joint name=\"" +
            side + "_knee\" type=\"revolute\"><parent link=\"trunk\"/><child link=\"" + side +
            "_shin\"/><axis xyz=\"0 1 0\"/><limit lower=\"-3\" upper=\"3\" effort=\"10\" "
            "velocity=\"10\"/></joint><joint name=\"" +
            side + "_sole\" type=\"fixed\"><parent link=\"" + side + "_shin\"/><child link=\"" + side +
            "_foot\"/></joint>";
  }
  write("biped.urdf", urdf + "</robot>");
  std::string rows =
      "time,JointPosLeft_knee,JointPosRight_knee,BaseAx,BaseAy,BaseAz,BaseWx,BaseWy,BaseWz,Left_Force,right_foot_fz\n";
  for (int k = 0; k < 300; ++k)
    rows += std::to_string(0.01 * k) + "," + std::to_string(std::sin(0.03 * k)) + ",0.1,0,0,9.81,0,0,0,15,1" +
            std::to_string(k % 3) + "\n";
  write("walk.csv", rows);
  const Draft draft = make_draft(path("biped.urdf"), {path("walk.csv"), path("walk.csv")}, folder_.string());
  EXPECT_THAT(draft.text, HasSubstr("feet: [left_foot, right_foot]"));
  EXPECT_THAT(draft.text, HasSubstr("drive: motion"));
  write("experiment.yaml", draft.text);
  EXPECT_TRUE(load_experiment(path("experiment.yaml")).recordings[0].has("/wrench/right_foot/force/z")) << draft.text;
  // Raw and filtered: a force has one column.
  for (size_t at = 0; (at = rows.find('\n', at)) != std::string::npos; at += 4) rows.insert(at, ",14");
  write("walk.csv", rows.replace(rows.find(",14"), 3, ",right_foot_force"));
  const std::string text = make_draft(path("biped.urdf"), {path("walk.csv")}, folder_.string()).text;
  const size_t first = text.find("/wrench/right_foot/force/z");
  EXPECT_NE(first, std::string::npos) << text;
  EXPECT_EQ(text.find("/wrench/right_foot/force/z", first + 1), std::string::npos) << text;
}

// A frame of the messages may be any text.
TEST_F(Drafts, OfABagWithAnOddFrameAreRead) {
  using namespace testing_bags;
  std::vector<Message> messages;
  for (int k = 0; k < 400; ++k) {
    const int64_t stamp = int64_t{5'000'000} * k;
    messages.push_back({"/states", stamp, make_joint_state(stamp, {"shoulder"}, {std::sin(0.02 * k)}, {}, {1.0})});
    messages.push_back(
        {"/tool", stamp,
         CdrWriter().put(int32_t{0}).put(uint32_t{0}).put(std::string("flange\nfeet: [upper]")).zeros(6).bytes()});
  }
  write_bag(folder_ / "motion", Storage::kMcap,
            {{"/states", "sensor_msgs/msg/JointState", kJointStateDefinition},
             {"/tool", "geometry_msgs/msg/WrenchStamped", ""}},
            messages);
  write("experiment.yaml", make_draft(path("arm.urdf"), {path("motion")}, folder_.string()).text);
  EXPECT_TRUE(load_experiment(path("experiment.yaml")).scenario.feet.empty());
}

// As a humanoid with pressure cells logs a squat: no inertial sensor, and the model writes its sides as letters.
TEST_F(Drafts, OfForcesUnderTwoFeetFloatWithoutAnInertialSensor) {
  const std::string mass =
      "<inertial><mass value=\"1\"/><inertia ixx=\"0.1\" iyy=\"0.1\" izz=\"0.1\" ixy=\"0\" ixz=\"0\" "
      "iyz=\"0\"/></inertial></link>";
  std::string urdf = "<robot name=\"biped\"><link name=\"trunk\">" + mass;
  for (const std::string side : {"L", "R"}) {
    urdf += "<link name=\"" + side + "_SHIN\">" + mass + "<link name=\"" + side + "_FOOT\">" + mass + "<link name=\"" +
            side + "_SOLE\">" + mass + "<joint name=\"" + side +
            "_KNEE\" type=\"revolute\"><parent link=\"trunk\"/><child link=\"" + side +
            "_SHIN\"/><axis xyz=\"0 1 0\"/><limit lower=\"-3\" upper=\"3\" effort=\"10\" velocity=\"10\"/></joint>";
    for (const std::string end : {"FOOT", "SOLE"})
      urdf += "<joint name=\"" + side + end + "\" type=\"fixed\"><parent link=\"" + side + "_SHIN\"/><child link=\"" +
              side + "_" + end + "\"/></joint>";
  }
  write("biped.urdf", urdf + "</robot>");
  std::string rows = "time,R_KNEE,L_KNEE,right_foot_fz,left_foot_fz\n",
              fingers = "time,R_KNEE,L_KNEE,right_finger_fz,left_finger_fz\n";
  for (int k = 0; k < 300; ++k) {
    const std::string row = std::to_string(0.01 * k) + "," + std::to_string(std::sin(0.03 * k)) + ",0.1,1" +
                            std::to_string(k % 3) + ",14\n";
    rows += row;
    fingers += row;
  }
  write("squat.csv", rows);
  const Draft draft = make_draft(path("biped.urdf"), {path("squat.csv"), path("squat.csv")}, folder_.string());
  EXPECT_THAT(draft.text, HasSubstr("base: floating     # (?) as the log has forces under feet"));
  EXPECT_THAT(draft.text, HasSubstr("feet: [R_FOOT, L_FOOT]"));
  EXPECT_THAT(draft.text, HasSubstr("drive: motion"));
  write("experiment.yaml", draft.text);
  EXPECT_TRUE(load_experiment(path("experiment.yaml")).recordings[0].has("/wrench/R_FOOT/force/z")) << draft.text;
  write("grip.csv", fingers);
  EXPECT_THAT(make_draft(path("biped.urdf"), {path("grip.csv"), path("grip.csv")}, folder_.string()).text,
              HasSubstr("base: fixed"));
}

TEST_F(Drafts, OfARobotWithoutJointsAreRefused) {
  write("box.urdf", "<robot name=\"box\"><link name=\"box\"/></robot>");
  write("log.txt", make_rows(" "));
  const std::string said = catch_complaint([&] { make_draft(path("box.urdf"), {path("log.txt")}, folder_.string()); });
  EXPECT_THAT(said, HasSubstr("box.urdf"));
  EXPECT_THAT(said, HasSubstr("no joint that moves"));
}

TEST_F(Drafts, OfAFileThatIsNotThereAreRefused) {
  EXPECT_THROW(make_draft(path("arm.urdf"), {path("none.csv")}, folder_.string()), InputError);
  write("log.txt", make_rows(" "));
  EXPECT_THAT(catch_complaint([&] {
                make_draft(path("arm.urdf"), {path("log.txt"), path("second.txt")}, folder_.string());
              }),
              HasSubstr("second.txt"));
  EXPECT_THROW(make_draft(path("none.urdf"), {path("none.csv")}, folder_.string()), InputError);
}

}  // namespace
}  // namespace hrp::diagnosis
