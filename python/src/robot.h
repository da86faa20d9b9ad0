// SPDX-License-Identifier: BSD-3-Clause
// A robot with the working memory of its multibody functions.
#pragma once

#include <memory>

#include "common/multibody/kinematics.h"
#include "common/robot/robot_description.h"

namespace hrp::python {

struct PyRobot {
  PyRobot(const RobotDescription& given, const Vector3d& gravity_W)
      : description(given), model(given.tree, gravity_W), data(model) {}
  RobotDescription description;
  Model model;
  Data data;
};

// Throws ValueError when `state` has not the robot's number of joints.
void check_state(const TreeSpec& tree, const State& state);

}  // namespace hrp::python
