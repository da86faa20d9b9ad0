// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>

#include "common/base/diagnostics.h"
#include "common/multibody/kinematics.h"
#include "common/robot/sole.h"
#include "servers/dynamics/simulator.h"

namespace hrp {
namespace {

// Half extent of a shape against direction d (unit, geometry axes): how far it reaches from its centre.
double calc_reach(const CollisionShape& shape, const Vector3d& d) {
  switch (shape.kind) {
    case ShapeKind::kBox: return 0.5 * shape.size.dot(d.cwiseAbs());
    case ShapeKind::kSphere: return shape.size.x();
    case ShapeKind::kCylinder: return shape.size.x() * d.head<2>().norm() + 0.5 * shape.size.y() * std::abs(d.z());
    case ShapeKind::kMesh: break;
  }
  return 0.0;
}

State make_state_on_origin(const RobotDescription& robot, const Scenario& scenario) {
  const TreeSpec& tree = robot.tree;
  State state;
  state.q = state.qd = Eigen::VectorXd::Zero(tree.num_joints());
  state.p_WB = scenario.initial_position;
  state.R_WB = Eigen::Quaterniond(make_rotation_from_rpy(scenario.initial_rpy));
  for (const auto& [name, value] : scenario.initial_joints) {
    const int joint = tree.find_joint(name);
    if (joint < 0) refuse_input({"", "initial.joints." + name}, "the robot has no such joint");
    state.q[joint] = value;
  }
  for (int i = 0; i < tree.num_joints(); ++i) {
    const MimicSpec& mimic = tree.joint(i).mimic;
    const bool given = scenario.initial_joints.count(tree.joint(i).name) > 0;
    if (mimic.joint >= 0 && !given) state.q[i] = mimic.multiplier * state.q[mimic.joint] + mimic.offset;
  }
  return state;
}

}  // namespace

double calc_initial_height(const RobotDescription& robot, const Scenario& scenario) {
  const bool any_mesh = std::any_of(robot.shapes.begin(), robot.shapes.end(), [](const CollisionShape& shape) {
    return shape.sole && shape.kind == ShapeKind::kMesh;
  });
  if (any_mesh || !robot.surfaces.empty()) return make_start_state(robot, scenario).p_WB.z();
  const State state = make_state_on_origin(robot, scenario);
  const Model model(robot.tree, scenario.gravity_W);
  Data data(model);
  update_kinematics(model, state, &data);
  const bool any_sole = std::any_of(robot.shapes.begin(), robot.shapes.end(), [](const CollisionShape& shape) {
    return shape.sole && shape.kind != ShapeKind::kMesh;
  });
  const Vector3d n = make_rotation_from_rpy({scenario.ground.roll, scenario.ground.pitch, 0.0}).col(2);
  const Vector3d ground(0.0, 0.0, scenario.ground.height);
  double lowest = std::numeric_limits<double>::infinity();
  for (const CollisionShape& shape : robot.shapes) {
    if (shape.kind == ShapeKind::kMesh || (any_sole && !shape.sole)) continue;
    const Transform X_WG = get_pose(data, shape.link) * shape.X_LG;
    lowest = std::min(lowest, n.dot(X_WG.p - ground) - calc_reach(shape, X_WG.R.transpose() * n));
  }
  if (!std::isfinite(lowest)) return scenario.initial_position.z();
  return scenario.initial_position.z() - lowest / n.z();
}

State make_initial_state(const RobotDescription& robot, const Scenario& scenario) {
  State state = make_state_on_origin(robot, scenario);
  if (scenario.floating_base && (scenario.ground.present || !robot.surfaces.empty()) &&
      !scenario.initial_height_given) {
    state.p_WB.z() = calc_initial_height(robot, scenario);
  }
  return state;
}

}  // namespace hrp
