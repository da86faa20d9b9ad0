// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/object_tree.h"

#include <algorithm>

#include "common/spatial/rpy.h"

namespace hrp {

LinkInertia calc_object_inertia(const ObjectSpec& object) {
  LinkInertia inertia;
  inertia.mass = object.mass;
  const Vector3d s = object.size.cwiseProduct(object.size);
  Vector3d moments;
  if (object.shape == "box") {
    moments = object.mass / 12.0 * Vector3d(s.y() + s.z(), s.z() + s.x(), s.x() + s.y());
  } else if (object.shape == "sphere") {
    moments.setConstant(0.4 * object.mass * s.x());
  } else {  // radius and length along z
    const double across = object.mass * (3.0 * s.x() + s.y()) / 12.0;
    moments = {across, across, 0.5 * object.mass * s.x()};
  }
  inertia.I_LLcm_L = moments.asDiagonal();
  return inertia;
}

CollisionShape make_object_shape(const ObjectSpec& object) {
  CollisionShape shape;
  shape.name = object.name;
  shape.size = object.size;
  shape.kind = object.shape == "sphere" ? ShapeKind::kSphere : object.shape == "cylinder" ? ShapeKind::kCylinder : ShapeKind::kBox;
  shape.sole = true;
  return shape;
}

RobotDescription make_object_robot(const ObjectSpec& object, const RobotDescription& robot) {
  RobotDescription result;
  LinkSpec link;
  link.name = object.name;
  link.inertia = calc_object_inertia(object);
  result.tree.name = object.name;
  result.tree.links.push_back(link);
  result.tree.frames.push_back({object.name, 0, Transform(), link.inertia});
  result.shapes.push_back(make_object_shape(object));
  result.surfaces = robot.surfaces;
  return result;
}

Scenario make_object_scenario(const ObjectSpec& object, const Scenario& scenario) {
  Scenario result;
  result.path = scenario.path;
  result.marks = scenario.marks;
  result.gravity_W = scenario.gravity_W;
  result.time_step = scenario.time_step;
  result.control_period = scenario.control_period;
  result.integrator = scenario.integrator;
  result.contact = scenario.contact;
  result.contact.model = "spring_damper";
  result.max_sole_points = scenario.max_sole_points;
  result.no_contact = scenario.no_contact;
  result.feet = {object.name};
  result.initial_position = object.X_WO.p;
  result.initial_height_given = true;
  result.initial_rpy = calc_rpy(object.X_WO.R);
  result.ground = scenario.ground;
  result.ground.friction = std::min(scenario.ground.friction, object.friction);
  result.obstacles = scenario.obstacles;
  for (ObstacleSpec& obstacle : result.obstacles) obstacle.friction = std::min(obstacle.friction, object.friction);
  return result;
}

}  // namespace hrp
