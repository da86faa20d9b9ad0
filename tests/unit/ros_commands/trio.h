// SPDX-License-Identifier: BSD-3-Clause
// A robot of three joints, messages for it, and a controller that plays them.
#pragma once

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "common/messages/convert_robot.h"
#include "controller/play.h"
#include "controller/ros/ros_controller.h"
#include "tests/unit/chain.h"

namespace hrp {

constexpr double kExact = 1e-12;   // a few roundings of numbers of size 1
constexpr double kPeriod = 0.005;  // [s]
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Three joints: -1 to 1 rad, 2 rad/s, 5 N m each; the last one slides and has no limits.
inline RobotDescription make_description() {
  RobotDescription description;
  description.tree = test::make_chain("trio", {"hip", "knee", "slide"});
  for (int i = 0; i < 2; ++i) {
    JointSpec& joint = description.tree.joint(i);
    joint.lower = -1.0;
    joint.upper = 1.0;
    joint.velocity_limit = 2.0;
    joint.effort_limit = 5.0;
  }
  description.tree.joint(2).kind = JointKind::kPrismatic;
  description.scenario_path = "trio.yaml";
  description.scenario =
      "robot: trio.urdf\n"
      "servo: {default: {kp: 1, kd: 0}}\n"
      "initial: {joints: {knee: 0.2}}\n"
      "steps: {time_step: 0.001, control_period: 0.005, duration: 10}\n";
  return description;
}

inline Robot make_trio() {
  const RobotDescription description = make_description();
  return make_robot(description, parse_scenario(description.scenario, description.scenario_path));
}

inline RosJointTrajectory make_message(const std::vector<std::string>& names) {
  RosJointTrajectory message;
  message.joint_names(names);
  return message;
}

inline void add_point(double time, const std::vector<double>& q, const std::vector<double>& qd,
                      RosJointTrajectory* message) {
  ::trajectory_msgs::msg::dds_::JointTrajectoryPoint_ point;
  point.positions(q);
  point.velocities(qd);
  point.time_from_start().sec(static_cast<int32_t>(std::floor(time)));
  point.time_from_start().nanosec(static_cast<uint32_t>(std::lround((time - std::floor(time)) * 1e9)));
  message->points().push_back(point);
}

// hip to 0.5 rad in 1 s, then knee and hip on.
inline RosJointTrajectory make_good_message() {
  RosJointTrajectory message = make_message({"hip", "knee"});
  add_point(1.0, {0.5, 0.2}, {0.0, 0.0}, &message);
  add_point(2.0, {0.6, 0.4}, {0.0, 0.0}, &message);
  return message;
}

class Played {
 public:
  Played() : Played(make_trio()) {}
  explicit Played(const Robot& r) : Played(r, make_scenario_controller(r)) {}
  Played(const Robot& r, std::unique_ptr<Controller> other) : robot(r), controller(r, std::move(other)) {
    controller.start(robot);
  }
  // The answer to the next sample.
  JointCommand step() {
    SensorData sensors;
    sensors.time = kPeriod * static_cast<double>(count_++);
    sensors.q = measured;
    return last = controller.control(sensors, robot);
  }
  JointCommand play(double seconds) {
    for (int i = 0; i < std::lround(seconds / kPeriod); ++i) step();
    return last;
  }
  void restart(long count) {
    count_ = count;
    controller.start(robot);
  }

  Robot robot;
  RosController controller;
  Eigen::VectorXd measured = Eigen::Vector3d(0.01, 0.02, 0.03);
  JointCommand last;

 private:
  long count_ = 0;
};

}  // namespace hrp
