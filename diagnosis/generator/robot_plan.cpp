// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "diagnosis/generator/robot_parts.h"

namespace hrp::cases {

// Solid box of the given mass, its centre at the centre of mass.
void set_box(LinkPlan& link, double mass, const Vec3& com, const Vec3& box) {
  const double x = box[0] * box[0], y = box[1] * box[1], z = box[2] * box[2];
  link.mass = mass;
  link.com = com;
  link.box = box;
  link.inertia = {mass * (y + z) / 12, mass * (x + z) / 12, mass * (x + y) / 12, 0, 0, 0};
}

LinkPlan make_link(const std::string& name, int parent, const std::string& joint_name, const Vec3& xyz,
                   const Vec3& axis) {
  LinkPlan link;
  link.name = name;
  link.parent = parent;
  link.joint.name = joint_name;
  link.joint.xyz = xyz;
  link.joint.axis = axis;
  return link;
}

double round_to(double value, int digits) {
  if (value == 0) return 0;
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) - digits + 1);
  return std::round(value / unit) * unit;
}

int find_joint(const RobotPlan& robot, const std::string& name) {
  for (int j = 0; j < joint_count(robot); ++j) {
    if (joint(robot, j).name == name) return j;
  }
  return -1;
}

int find_role(const RobotPlan& robot, const std::string& role) {
  for (int j = 0; j < joint_count(robot); ++j) {
    if (joint(robot, j).role == role) return j;
  }
  return -1;
}

}  // namespace hrp::cases
