// SPDX-License-Identifier: BSD-3-Clause
// CSV recordings as messages: then everything that shows a log shows them, too.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "common/base/diagnostics.h"
#include "common/base/has.h"
#include "common/base/read_file.h"
#include "common/messages/cdr.h"
#include "common/messages/topics.h"
#include "common/robot/experiment_keys.h"
#include "common/robot/scenario.h"
#include "hrp_idl/control.h"
#include "hrp_idl/dynamics.h"
#include "servers/viewer/csv_table.h"
#include "servers/viewer/recording.h"

namespace hrp {
namespace {

namespace fs = std::filesystem;

std::string read_text(const std::string& path) {
  std::ifstream file(path);
  return read_rest(file, path);
}

// The part of "/imu/chest/..." behind `prefix`, up to the next slash; empty for other names.
std::string find_part(const std::string& name, const std::string& prefix) {
  if (name.rfind(prefix, 0) != 0) return "";
  return name.substr(prefix.size(), name.find('/', prefix.size()) - prefix.size());
}

std::vector<std::string> find_parts(const CsvTable& table, const std::vector<std::string>& prefixes) {
  std::vector<std::string> parts;
  for (const std::string& name : table.names) {
    for (const std::string& prefix : prefixes) {
      const std::string part = find_part(name, prefix);
      if (!part.empty() && !has(parts, part)) parts.push_back(part);
    }
  }
  return parts;
}

class RowReader {
 public:
  RowReader(const CsvTable& table, size_t row) : table_(table), row_(row) {}
  double get(const std::string& name, double otherwise = kNoValue) const {
    const auto* column = table_.find(name);
    return column ? (*column)[row_] : otherwise;
  }
  std::vector<double> get_joints(const std::vector<std::string>& joints, const std::string& prefix,
                                 const std::string& what) const {
    std::vector<double> values;
    for (const std::string& joint : joints) values.push_back(get(prefix + joint + what));
    return values;
  }
  msg::Vector3 get_vector(const std::string& name, double otherwise = kNoValue) const {
    msg::Vector3 v;
    v.x(get(name + "/x", otherwise));
    v.y(get(name + "/y", otherwise));
    v.z(get(name + "/z", otherwise));
    return v;
  }
  msg::Quaternion get_quaternion(const std::string& name) const {
    msg::Quaternion q;
    q.w(get(name + "/w", 1.0));
    q.x(get(name + "/x", 0.0));
    q.y(get(name + "/y", 0.0));
    q.z(get(name + "/z", 0.0));
    return q;
  }

 private:
  const CsvTable& table_;
  size_t row_;
};

class CsvRecorder {
 public:
  CsvRecorder(const Scenario& scenario, const CsvTable& table, const std::string& name)
      : scenario_(scenario), table_(table), recording_(std::make_unique<Recording>(name)) {
    joints_ = find_parts(table, {"/joint_states/", "/joint_commands/"});
    imus_ = find_parts(table, {"/imu/"});
    wrenches_ = find_parts(table, {"/wrench/"});
    for (const auto& [topic, type] : {std::pair(topics::kRobotState.name, "hrp::msg::RobotState"),
                                      std::pair(topics::kSensorData.name, "hrp::msg::SensorData"),
                                      std::pair(topics::kJointCommands.name, "hrp::msg::JointCommands")}) {
      recording_->add_topic(topic, get_schema().find_struct(type), find_schema_text(type));
    }
  }

  std::unique_ptr<Recording> make() {
    describe();
    const auto& times = *table_.find("time");
    for (size_t row = 0; row < times.size(); ++row) {
      if (std::isfinite(times[row])) take(row, times[row]);
    }
    for (const std::string& note : table_.notes) recording_->add_note(note);
    const bool base = table_.find("/base/pose/position/x") != nullptr;
    if (scenario_.floating_base && !base)
      recording_->add_note("no base pose was recorded: the base is shown where it began");
    recording_->finish();
    return std::move(recording_);
  }

 private:
  // Names and text are all that a page needs: it reads the URDF itself.
  void describe() {
    msg::RobotDescription description;
    description.name(fs::path(scenario_.robot).stem().string());
    description.urdf_path(scenario_.robot);
    const std::string text = read_text(scenario_.robot);
    const bool is_urdf = text.find("<robot") != std::string::npos;
    description.urdf(is_urdf ? text : "<robot name=\"none\"><link name=\"base\"/></robot>");
    if (!is_urdf)
      recording_->add_note("the page draws URDFs only, and " + scenario_.robot +
                           " is none: its charts are shown without a robot");
    description.scenario(scenario_.text);
    description.scenario_path(scenario_.path);
    description.floating_base(scenario_.floating_base);
    for (const std::string& name : joints_) {
      msg::JointDescription joint;
      joint.name(name);
      joint.kind(msg::JOINT_REVOLUTE);
      joint.lower(kNoValue);
      joint.upper(kNoValue);
      description.joints().push_back(joint);
    }
    recording_->set_scene(make_scene(description));
  }

  msg::Pose find_base(const RowReader& row) const {
    msg::Pose pose;
    const Eigen::Quaterniond start(make_rotation_from_rpy(scenario_.initial_rpy));
    pose.rotation().w(start.w());
    pose.rotation().x(start.x());
    pose.rotation().y(start.y());
    pose.rotation().z(start.z());
    pose.translation().x(scenario_.initial_position.x());
    pose.translation().y(scenario_.initial_position.y());
    pose.translation().z(scenario_.initial_position.z());
    if (table_.find("/base/pose/position/x")) pose.translation() = row.get_vector("/base/pose/position");
    if (table_.find("/base/pose/orientation/w")) pose.rotation() = row.get_quaternion("/base/pose/orientation");
    return pose;
  }

  void take(size_t index, double time) {
    const RowReader row(table_, index);
    msg::Header header;
    header.step(index);
    header.time(time);
    msg::SensorData sensors;
    sensors.header(header);
    sensors.positions(row.get_joints(joints_, "/joint_states/", "/position"));
    sensors.velocities(row.get_joints(joints_, "/joint_states/", "/velocity"));
    sensors.efforts(row.get_joints(joints_, "/joint_states/", "/effort"));
    add_sensors(row, &sensors);
    add(topics::kSensorData.name, time, sensors);
    msg::JointCommands commands;
    commands.header(header);
    commands.positions(row.get_joints(joints_, "/joint_commands/", "/position"));
    commands.velocities(row.get_joints(joints_, "/joint_commands/", "/velocity"));
    add(topics::kJointCommands.name, time, commands);
    msg::RobotState state;
    state.header(header);
    state.X_WB(find_base(row));
    state.positions(sensors.positions());
    state.velocities(sensors.velocities());
    state.efforts(sensors.efforts());
    add(topics::kRobotState.name, time, state);
  }

  void add_sensors(const RowReader& row, msg::SensorData* sensors) const {
    for (const std::string& name : imus_) {
      msg::ImuSample imu;
      imu.name(name);
      imu.orientation(row.get_quaternion("/imu/" + name + "/orientation"));
      imu.angular_velocity(row.get_vector("/imu/" + name + "/angular_velocity"));
      imu.linear_acceleration(row.get_vector("/imu/" + name + "/linear_acceleration"));
      sensors->imus().push_back(imu);
    }
    for (const std::string& name : wrenches_) {
      msg::WrenchSample wrench;
      wrench.name(name);
      wrench.force(row.get_vector("/wrench/" + name + "/force"));
      wrench.torque(row.get_vector("/wrench/" + name + "/torque"));
      sensors->wrenches().push_back(wrench);
    }
    if (table_.find("/base/pose/position/x")) sensors->base_pose().push_back(find_base(row));
  }

  template <typename Message>
  void add(const std::string& topic, double time, const Message& message) {
    recording_->add(topic, time, encode(message, &buffer_));
  }

  const Scenario& scenario_;
  const CsvTable& table_;
  std::unique_ptr<Recording> recording_;
  std::vector<std::string> joints_, imus_, wrenches_;
  std::vector<char> buffer_;
};

}  // namespace

std::vector<std::unique_ptr<Recording>> read_experiment(const std::string& path) {
  std::error_code error;
  const std::string file = fs::is_directory(path, error) ? (fs::path(path) / "experiment.yaml").string() : path;
  const Scenario scenario = load_scenario(file);
  const ExperimentKeys keys = parse_experiment_keys(scenario.text, scenario.path);
  std::vector<std::unique_ptr<Recording>> recordings;
  for (const RecordingSpec& spec : keys.recordings) {
    if (fs::path(spec.file).extension() == ".mcap") {
      recordings.push_back(read_log(spec.file));
    } else {
      recordings.push_back(CsvRecorder(scenario, read_csv_table(spec.file), spec.name).make());
    }
  }
  if (!recordings.empty()) return recordings;
  refuse_input({file, "recordings"},
               "names no recording, so there is nothing to show; simulate it with scripts/simulate.sh");
}

}  // namespace hrp
