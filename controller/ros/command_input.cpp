// SPDX-License-Identifier: BSD-3-Clause
#include "controller/ros/command_input.h"

#include <cmath>
#include <cstdint>
#include <cstdio>

#include "common/base/diagnostics.h"
#include "common/base/printable.h"

namespace hrp {
namespace {

// Plans come with six decimals: a limit that was rounded to them is still met. [rad or m, and their rates]
constexpr double kRounding = 1e-6;
constexpr int64_t kNanoseconds = 1000000000;

using RosPoint = ::trajectory_msgs::msg::dds_::JointTrajectoryPoint_;

std::string print(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.7g", value);
  return text;
}

std::string print_index(const std::string& list, size_t i) { return list + "[" + std::to_string(i) + "]"; }

void check_count(const std::string& topic, const std::string& field, size_t count, size_t expected,
                 const std::string& why) {
  if (count == expected) return;
  refuse_input({topic, field}, std::to_string(count) + " values; expected " + std::to_string(expected) + why);
}

const JointSpec& get_joint(const Robot& robot, int joint) { return robot.description->tree.joint(joint); }

std::string find_unit(const Robot& robot, int joint) {
  return get_joint(robot, joint).kind == JointKind::kPrismatic ? " m" : " rad";
}

// `what`: "is" at a point, "reaches" on the way to it.
void check_range(const std::string& topic, const std::string& field, const std::string& what, double value,
                 double lower, double upper, const std::string& unit) {
  if (value >= lower - kRounding && value <= upper + kRounding) return;
  refuse_input({topic, field}, what + " " + print(value) + unit + "; expected " + print(lower) + " to " + print(upper) +
                                   unit + ", the joint's limits");
}

void check_finite(const std::string& topic, const std::string& field, const std::string& joint, double value) {
  if (!std::isfinite(value))
    refuse_input({topic, field}, "joint '" + joint + "' is told " + print(value) + "; expected a finite number");
}

void check_position(const std::string& topic, const std::string& field, const Robot& robot, int joint, double value) {
  const std::string& name = robot.joints[static_cast<size_t>(joint)];
  check_finite(topic, field, name, value);
  check_range(topic, field, "joint '" + name + "' is told", value, robot.lower[joint], robot.upper[joint],
              find_unit(robot, joint));
}

// One message, read field by field.
class TrajectoryReader {
 public:
  TrajectoryReader(const RosJointTrajectory& message, const Robot& robot, const JointCommand& present,
                   const std::string& topic)
      : message_(message), robot_(robot), present_(present), topic_(topic) {}

  Trajectory read() {
    find_joints();
    if (message_.points().empty()) return make_hold(present_);
    if (joints_.empty()) refuse_here("joint_names", "empty; expected the joints that the points are for");
    for (size_t i = 0; i < message_.points().size(); ++i) check_point(i);
    Trajectory trajectory(make_points(), !message_.points()[0].velocities().empty());
    for (size_t i = 0; i + 1 < trajectory.points().size(); ++i) check_way(trajectory, i);
    return trajectory;
  }

 private:
  [[noreturn]] void refuse_here(const std::string& field, const std::string& message) const {
    refuse_input({topic_, field}, message);
  }

  void find_joints() {
    std::vector<bool> named(robot_.joints.size(), false);
    for (size_t i = 0; i < message_.joint_names().size(); ++i) {
      const std::string name = message_.joint_names()[i];
      const int joint = robot_.find_joint(name);
      if (joint < 0) refuse_unknown(print_index("joint_names", i), name);
      if (named[static_cast<size_t>(joint)])
        refuse_here(print_index("joint_names", i), "'" + name + "' for the second time; expected each joint once");
      named[static_cast<size_t>(joint)] = true;
      joints_.push_back(joint);
    }
  }

  void refuse_unknown(const std::string& field, const std::string& name) const {
    const std::string nearest = find_nearest(name, robot_.joints);
    refuse_here(field, "'" + make_printable_line(name) + "'; expected a joint of " + robot_.name +
                           (nearest.empty() ? ", see hrp-topic echo joint_states" : "; is it '" + nearest + "'?"));
  }

  static int64_t find_time(const RosPoint& point) {
    return int64_t{point.time_from_start().sec()} * kNanoseconds + point.time_from_start().nanosec();
  }
  static std::string print_time(const RosPoint& point) {
    return print(static_cast<double>(find_time(point)) / kNanoseconds) + " s";
  }

  void check_time(size_t i) const {
    const RosPoint& point = message_.points()[i];
    const std::string field = print_index("points", i) + ".time_from_start";
    if (point.time_from_start().nanosec() >= kNanoseconds) {
      refuse_here(field + ".nanosec",
                  std::to_string(point.time_from_start().nanosec()) + "; expected less than 1000000000");
    }
    if (i == 0 && find_time(point) < 0) refuse_here(field, print_time(point) + "; expected 0 or later");
    if (i > 0 && find_time(point) <= find_time(message_.points()[i - 1])) {
      refuse_here(field, print_time(point) + "; expected later than " + print_time(message_.points()[i - 1]) +
                             " of the point before");
    }
  }

  // Either all points have them or none.
  void check_optional(const std::string& field, const std::vector<double>& values,
                      const std::vector<double>& first) const {
    check_count(topic_, field, values.size(), first.empty() ? 0 : joints_.size(),
                first.empty() ? ", as in the first point" : ", one a joint of joint_names");
    check_all_finite(field, values);
  }

  void check_all_finite(const std::string& field, const std::vector<double>& values) const {
    for (size_t k = 0; k < values.size(); ++k) {
      check_finite(topic_, print_index(field, k), message_.joint_names()[k], values[k]);
    }
  }

  void check_point(size_t i) const {
    check_time(i);
    const RosPoint &point = message_.points()[i], &first = message_.points()[0];
    const std::string field = print_index("points", i) + ".";
    check_count(topic_, field + "positions", point.positions().size(), joints_.size(), ", one a joint of joint_names");
    check_optional(field + "velocities", point.velocities(), first.velocities());
    check_optional(field + "accelerations", point.accelerations(), first.accelerations());
    check_optional(field + "effort", point.effort(), first.effort());
    for (size_t k = 0; k < joints_.size(); ++k) {
      check_position(topic_, print_index(field + "positions", k), robot_, joints_[k], point.positions()[k]);
      if (!point.effort().empty()) check_effort(print_index(field + "effort", k), joints_[k], point.effort()[k]);
    }
  }

  void check_effort(const std::string& field, int joint, double value) const {
    const double limit = robot_.effort_limit[joint];
    const bool prismatic = get_joint(robot_, joint).kind == JointKind::kPrismatic;
    check_range(topic_, field, "joint '" + robot_.joints[static_cast<size_t>(joint)] + "' is told", value, -limit,
                limit, prismatic ? " N" : " N m");
  }

  TrajectoryPoint make_point(const RosPoint& point, const JointCommand& before) const {
    TrajectoryPoint made{static_cast<double>(find_time(point)) / kNanoseconds, before};
    for (size_t k = 0; k < joints_.size(); ++k) {
      const int joint = joints_[k];
      made.command.q[joint] = point.positions()[k];
      made.command.qd[joint] = point.velocities().empty() ? 0.0 : point.velocities()[k];
      made.command.effort[joint] = point.effort().empty() ? 0.0 : point.effort()[k];
    }
    return made;
  }

  // The present command is where it begins, unless the message says where to be at once.
  std::vector<TrajectoryPoint> make_points() const {
    JointCommand begin = present_;
    begin.qd.setZero();
    for (const int joint : joints_) {
      begin.qd[joint] = present_.qd[joint];
      if (message_.points()[0].effort().empty()) begin.effort[joint] = 0.0;
    }
    JointCommand rest = begin;
    rest.qd.setZero();
    std::vector<TrajectoryPoint> points;
    if (find_time(message_.points()[0]) > 0) points.push_back({0.0, begin});
    for (const RosPoint& point : message_.points()) points.push_back(make_point(point, rest));
    return points;
  }

  // Point i of the message is the last one of `points`.
  void check_way(const Trajectory& trajectory, size_t segment) const {
    const size_t i = segment + 1 - (trajectory.points().size() - message_.points().size());
    for (size_t k = 0; k < joints_.size(); ++k) {
      const int joint = joints_[k];
      const CubicSegment way = trajectory.find_segment(segment, joint);
      const std::string what = "on the way there joint '" + robot_.joints[static_cast<size_t>(joint)] + "' reaches";
      const std::string unit = find_unit(robot_, joint);
      const double speed = get_joint(robot_, joint).velocity_limit;
      for (const double v : {calc_velocity_extremes(way).lowest, calc_velocity_extremes(way).highest}) {
        check_range(topic_, print_index("points", i), what, v, -speed, speed, unit + "/s");
      }
      for (const double q : {calc_position_extremes(way).lowest, calc_position_extremes(way).highest}) {
        // Where it begins is no choice of the message.
        if (q != way.q0)
          check_range(topic_, print_index("points", i), what, q, robot_.lower[joint], robot_.upper[joint], unit);
      }
    }
  }

  const RosJointTrajectory& message_;
  const Robot& robot_;
  const JointCommand& present_;
  const std::string& topic_;
  std::vector<int> joints_;  // of joint_names
};

}  // namespace

Trajectory make_trajectory(const RosJointTrajectory& message, const Robot& robot, const JointCommand& present,
                           const std::string& topic) {
  return TrajectoryReader(message, robot, present, topic).read();
}

Trajectory make_trajectory(const RosPositions& message, const Robot& robot, const std::string& topic) {
  if (message.layout().data_offset() != 0) {
    refuse_input({topic, "layout.data_offset"}, std::to_string(message.layout().data_offset()) + "; expected 0");
  }
  const std::vector<double>& data = message.data();
  check_count(topic, "data", data.size(), robot.joints.size(), ", one a joint in the order of joint_states");
  JointCommand command;
  command.q.resize(static_cast<Eigen::Index>(data.size()));
  command.effort.setZero(command.q.size());
  for (size_t i = 0; i < data.size(); ++i) {
    check_position(topic, print_index("data", i), robot, static_cast<int>(i), data[i]);
    command.q[static_cast<Eigen::Index>(i)] = data[i];
  }
  return make_hold(command);
}

}  // namespace hrp
