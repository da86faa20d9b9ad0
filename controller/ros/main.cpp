// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/runner.h"
#include "controller/ros/ros_controller.h"

int main(int argc, char** argv) {
  return hrp::run_server(
      argc, argv,
      {"controller", "hrp-controller-ros",
       "A controller that nodes of ROS 2 command: trajectory_msgs/JointTrajectory on rt/joint_trajectory,\n"
       "std_msgs/Float64MultiArray on rt/position_commands. Joints that no message has named follow the scenario's "
       "controller."},
      [](const hrp::NodeContext& context) { return std::make_unique<hrp::RosControllerNode>(context); });
}
