// SPDX-License-Identifier: BSD-3-Clause
#include "common/log/log_table.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "common/base/diagnostics.h"
#include "common/messages/cdr.h"
#include "common/messages/logged_description.h"
#include "common/messages/topics.h"
#include "common/robot/foot_bush.h"
#include "common/robot/scenario.h"
#include "hrp_idl/control.h"
#include "hrp_idl/dynamics.h"
#include "hrp_idl/model.h"

namespace hrp {
namespace {

// Writes names on the first row and values on every row, so that both are listed once.
class RowWriter {
 public:
  RowWriter(std::vector<std::string>* names, std::vector<double>* row) : names_(names), row_(row) {}
  void add(const std::string& name, double value) {
    if (names_ != nullptr) names_->push_back(name);
    row_->push_back(value);
  }
  void add(const std::string& name, const msg::Vector3& v) {
    add(name + "/x", v.x());
    add(name + "/y", v.y());
    add(name + "/z", v.z());
  }
  void add(const std::string& name, const msg::Quaternion& q) {
    add(name + "/x", q.x());
    add(name + "/y", q.y());
    add(name + "/z", q.z());
    add(name + "/w", q.w());
  }

 private:
  std::vector<std::string>* names_;
  std::vector<double>* row_;
};

double get_or_nan(const std::vector<double>& values, size_t i) {
  return i < values.size() ? values[i] : std::numeric_limits<double>::quiet_NaN();
}

void add_sensors(const msg::SensorData& sensors, RowWriter* row) {
  for (const msg::ImuSample& imu : sensors.imus()) {
    row->add("/imu/" + imu.name() + "/orientation", imu.orientation());
    row->add("/imu/" + imu.name() + "/angular_velocity", imu.angular_velocity());
    row->add("/imu/" + imu.name() + "/linear_acceleration", imu.linear_acceleration());
  }
  for (const msg::WrenchSample& wrench : sensors.wrenches()) {
    row->add("/wrench/" + wrench.name() + "/force", wrench.force());
    row->add("/wrench/" + wrench.name() + "/torque", wrench.torque());
  }
  if (!sensors.base_pose().empty()) {
    row->add("/base/pose/position", sensors.base_pose()[0].translation());
    row->add("/base/pose/orientation", sensors.base_pose()[0].rotation());
  }
  if (!sensors.base_twist().empty()) {
    row->add("/base/twist/linear", sensors.base_twist()[0].linear());
    row->add("/base/twist/angular", sensors.base_twist()[0].angular());
  }
}

// Of a log whose scenario this program does not understand, the default.
std::string find_interpolation(const msg::RobotDescription& robot) {
  try {
    return parse_scenario(robot.scenario(), robot.scenario_path()).interpolation;
  } catch (const InputError&) {
    return Scenario().interpolation;
  }
}

class TableMaker {
 public:
  void take_description(const msg::RobotDescription& robot) {
    lead_ = find_interpolation(robot) != "hold";
    for (size_t i = 0; i < robot.joints().size(); ++i) {
      const msg::JointDescription& joint = robot.joints()[i];
      if (!joint.actuated() && is_bush_joint(joint.name())) continue;
      joints_.push_back(joint.name());
      index_.push_back(i);
    }
  }

  void take_sensors(const msg::SensorData& sensors) {
    std::vector<double> values;
    RowWriter row(table_.rows.empty() ? &table_.names : nullptr, &values);
    row.add("time", sensors.header().time());
    for (size_t i = 0; i < joints_.size(); ++i) {
      const std::string name = "/joint_commands/" + joints_[i];
      row.add(name + "/position", get_or_nan(next_positions_, index_[i]));
      row.add(name + "/velocity", get_or_nan(next_velocities_, index_[i]));
    }
    next_positions_.clear();
    next_velocities_.clear();
    add_joints(sensors, &row);
    add_sensors(sensors, &row);
    step_ = sensors.header().step();
    table_.rows.push_back(std::move(values));
  }

  // The reference goes to an interpolated command within one period and is there at the next row; a held command acts
  // from the instant of its own row on.
  void take_commands(const msg::JointCommands& commands) {
    if (table_.rows.empty() || commands.header().step() != step_) return;
    next_positions_ = commands.positions();
    next_velocities_ = commands.velocities();
    next_velocities_.resize(next_positions_.size(), 0.0);
    if (lead_) return;
    std::vector<double>& row = table_.rows.back();
    for (size_t i = 0; i < joints_.size(); ++i) {
      row[1 + 2 * i] = get_or_nan(next_positions_, index_[i]);
      row[2 + 2 * i] = get_or_nan(next_velocities_, index_[i]);
    }
    next_positions_.clear();
    next_velocities_.clear();
  }

  LogTable table_;

 private:
  void add_joints(const msg::SensorData& sensors, RowWriter* row) const {
    for (size_t i = 0; i < joints_.size(); ++i) {
      const std::string name = "/joint_states/" + joints_[i];
      row->add(name + "/position", get_or_nan(sensors.positions(), index_[i]));
      row->add(name + "/velocity", get_or_nan(sensors.velocities(), index_[i]));
      row->add(name + "/effort", get_or_nan(sensors.efforts(), index_[i]));
    }
  }

  std::vector<std::string> joints_;  // those with an encoder
  std::vector<size_t> index_;        // of each one in the messages
  bool lead_ = false;                // commands stand for the next row
  std::vector<double> next_positions_, next_velocities_;
  uint64_t step_ = 0;
};

}  // namespace

LogTable read_log_table(mcap::Reader* log) {
  const mcap::Channel* description = log->find_channel(topics::kRobotDescription.name);
  const mcap::Channel* sensors = log->find_channel(topics::kSensorData.name);
  const mcap::Channel* commands = log->find_channel(topics::kJointCommands.name);
  if (description == nullptr || sensors == nullptr || commands == nullptr) {
    throw std::runtime_error(log->path() + ": no log of a simulation");
  }
  TableMaker maker;
  msg::SensorData sensor_data;
  msg::JointCommands joint_commands;
  log->read_messages(
      [&](const mcap::Message& message) {
        const Bytes sample{message.data, message.size};
        if (message.channel_id == sensors->id) {
          decode(sample, &sensor_data);
          maker.take_sensors(sensor_data);
        } else if (message.channel_id == commands->id) {
          decode(sample, &joint_commands);
          maker.take_commands(joint_commands);
        } else {
          msg::RobotDescription robot;
          decode_logged(sample, &robot);
          maker.take_description(robot);
        }
        return true;
      },
      {description->topic, sensors->topic, commands->topic});
  return std::move(maker.table_);
}

}  // namespace hrp
