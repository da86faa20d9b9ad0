// SPDX-License-Identifier: BSD-3-Clause
// Commands that come in as messages of ROS 2 -> trajectories of all joints. What cannot be is refused as a whole: an
// InputError of one line with topic, field, value and what was expected.
#pragma once

#include <string>

#include "controller/client.h"
#include "controller/ros/trajectory.h"
#include "hrp_idl/ros_views.h"

namespace hrp {

using RosJointTrajectory = ::trajectory_msgs::msg::dds_::JointTrajectory_;
using RosPositions = ::std_msgs::msg::dds_::Float64MultiArray_;

// From the present command (q, qd, effort of all joints) through the points of the message. Joints that it does not
// name hold what they are told now. Without points: all joints do. `topic`: that the message came on.
Trajectory make_trajectory(const RosJointTrajectory& message, const Robot& robot, const JointCommand& present,
                           const std::string& topic);

// Positions of all joints, in the order of robot.joints, from now on.
Trajectory make_trajectory(const RosPositions& message, const Robot& robot, const std::string& topic);

}  // namespace hrp
