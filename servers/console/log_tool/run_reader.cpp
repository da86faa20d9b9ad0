// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/log_tool/run_reader.h"

#include <cmath>
#include <stdexcept>

#include "common/base/ros_definitions.h"
#include "common/messages/cdr.h"
#include "common/messages/convert.h"
#include "common/messages/convert_robot.h"
#include "common/messages/logged_description.h"
#include "common/messages/topics.h"
#include "common/robot/movers.h"
#include "servers/console/log_tool/log_file.h"

namespace hrp {
namespace {

constexpr double kSameTime = 1e-6;  // [s]

// Lets through the first sample at or after each multiple of the period.
class Thinner {
 public:
  explicit Thinner(double rate) : rate_(rate) {}
  bool take(double time) {
    if (rate_ <= 0.0) return true;
    if (time < next_ - kSameTime) return false;
    next_ = (std::floor((time + kSameTime) * rate_) + 1.0) / rate_;
    return true;
  }

 private:
  double rate_, next_ = 0.0;
};

class Pass {
 public:
  Pass(double rate, RunListener* listener) : rate_(rate), steps_(rate), listener_(*listener) {}

  void take(const std::string& topic, const std::string& type, const mcap::Message& message) {
    listener_.on_message(message);
    const Bytes sample{message.data, message.size};
    place_ = {message.log_time, message.sequence, static_cast<double>(message.log_time) * 1e-9};
    if (topic == topics::kRobotDescription.name) return take_robot(sample);
    if (!has_robot_) return;
    if (!topics::find_ros_topic(topic).empty()) return listener_.on_picture(topic, find_ros_name(type), sample, place_);
    if (topic == topics::kRobotState.name) return take_state(sample);
    if (topic == topics::kContactForces.name) return take_forces(sample);
    for (size_t k = 0; k < robots_.size(); ++k) {
      if (topic == robots_[k].sensors) return take_sensors(k, sample);
      if (topic == robots_[k].commands) return take_commands(k, sample);
    }
  }
  bool has_robot() const { return has_robot_; }

 private:
  void take_robot(Bytes sample) {
    if (has_robot_) return;
    msg::RobotDescription description;
    decode_logged(sample, &description);
    RobotDescription robot;
    from_message(description, &robot);
    has_robot_ = true;
    const Scenario scenario = parse_scenario(robot.scenario, robot.scenario_path);
    add_robot("");
    for (const std::string& name : list_robots(scenario)) add_robot(name);
    listener_.on_robot(robot, scenario, place_);
  }
  void add_robot(const std::string& name) {
    robots_.push_back({topics::of_robot(topics::kSensorData, name).name,
                       topics::of_robot(topics::kJointCommands, name).name, Thinner(rate_), Thinner(rate_)});
  }

  void take_sensors(size_t robot, Bytes sample) {
    if (!robots_[robot].sensors_rate.take(place_.time)) return;
    decode(sample, &sensor_data_);
    listener_.on_sensors(robot, sensor_data_, place_);
  }
  void take_commands(size_t robot, Bytes sample) {
    if (!robots_[robot].commands_rate.take(place_.time)) return;
    decode(sample, &joint_commands_);
    listener_.on_commands(robot, joint_commands_, place_);
  }

  // State and forces of one step come in either order.
  void take_state(Bytes sample) {
    state_wanted_ = steps_.take(place_.time);
    if (!state_wanted_) return;
    decode_logged(sample, &robot_state_);
    from_message(robot_state_, &run_step_.state);
    from_message(robot_state_, &run_step_.others);
    from_message(robot_state_, &run_step_.pushes);
    step_ = robot_state_.header().step();
    if (forces_step_ == step_ || step_ == 0) hand_out();
  }
  void take_forces(Bytes sample) {
    decode(sample, &contact_forces_);
    forces_step_ = contact_forces_.header().step();
    if (!state_wanted_ || forces_step_ != step_) return;
    hand_out();
  }
  void hand_out() {
    run_step_.forces.clear();
    if (step_ > 0) from_message(contact_forces_, &run_step_.forces);
    state_wanted_ = false;
    listener_.on_step(run_step_, place_);
  }

  // Topics of a robot.
  struct Robot {
    std::string sensors, commands;
    Thinner sensors_rate, commands_rate;
  };
  double rate_;
  Thinner steps_;
  std::vector<Robot> robots_;
  RunListener& listener_;
  LogPlace place_;
  bool has_robot_ = false, state_wanted_ = false;
  uint64_t step_ = 0, forces_step_ = UINT64_MAX;
  RunStep run_step_;
  msg::RobotState robot_state_;
  msg::ContactForces contact_forces_;
  msg::SensorData sensor_data_;
  msg::JointCommands joint_commands_;
};

}  // namespace

int read_run(mcap::Reader* log, double rate, RunListener* listener) {
  Pass pass(rate, listener);
  log->read_messages([&](const mcap::Message& message) {
    const mcap::Channel& channel = log->channels().at(message.channel_id);
    const auto schema = log->schemas().find(channel.schema_id);
    pass.take(channel.topic, schema == log->schemas().end() ? "" : schema->second.name, message);
    return true;
  });
  if (!pass.has_robot()) throw std::runtime_error(log->path() + ": no log of a simulation: it has no robot");
  return say_damage(*log);
}

}  // namespace hrp
