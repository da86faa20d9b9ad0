// SPDX-License-Identifier: BSD-3-Clause
#include "tests/physics/rigs.h"

#include "common/multibody/kinematics.h"
#include "common/robot/foot_bush.h"

namespace hrp::rigs {

ContactSet CornerFinder::find(const Model& model, const State& state) const {
  Data data(model);
  update_kinematics(model, state, &data);
  ContactSet contacts;
  for (const Corner& corner : corners) {
    const Vector3d p = get_pose(data, corner.link) * corner.p_LC;
    const double depth = height * n.z() - n.dot(p);
    if (depth < -margin) continue;
    if (contacts.empty() || contacts.back().body_a != corner.link) {
      contacts.emplace_back();
      contacts.back().body_a = corner.link;
      contacts.back().friction = friction;
      contacts.back().p_WR = get_pose(data, corner.link).p;
    }
    ContactPoint point;
    point.p_WC = p + 0.5 * depth * n;
    point.n_BA_W = n;
    point.depth = depth;
    contacts.back().points.push_back(point);
  }
  return contacts;
}

Biped make_biped() {
  Biped biped;
  biped.robot = make_body(make_box_inertia(42.0, {0.2, 0.35, 0.6}, {0, 0, 0.25}));
  RobotDescription* robot = &biped.robot;
  for (int side = 0; side < 2; ++side) {
    const std::string name = side == 0 ? "l" : "r";
    const double y = side == 0 ? 0.095 : -0.095;
    const LinkInertia thigh = make_box_inertia(4.0, {0.1, 0.1, 0.3}, {0, 0, -0.15});
    const LinkInertia shank = make_box_inertia(2.5, {0.08, 0.08, 0.3}, {0, 0, -0.15});
    const LinkInertia ankle = make_box_inertia(0.5, {0.06, 0.06, 0.06});
    const LinkInertia foot = make_box_inertia(1.0, 2.0 * biped.sole_half, biped.sole_centre);
    const int hip = add_link(robot, name + "_hip", 0, {0, y, -0.095}, Vector3d::UnitY(), thigh);
    const int knee = add_link(robot, name + "_knee", hip, {0, 0, -0.3}, Vector3d::UnitY(), shank);
    const int pitch = add_link(robot, name + "_ankle", knee, {0, 0, -0.3}, Vector3d::UnitY(), ankle);
    biped.feet[side] = add_link(robot, name + "_foot", pitch, Vector3d::Zero(), Vector3d::UnitX(), foot);
  }
  for (LinkSpec& link : robot->tree.links) link.joint.rotor_inertia = link.parent < 0 ? 0.0 : 0.1;
  return biped;
}

void add_bushes(const FootBushSpec& spec, Biped* biped) {
  FootBushSpec centred = spec;
  centred.center = biped->sole_centre - Vector3d(0, 0, biped->sole_half.z());
  for (int side = 0; side < 2; ++side) {
    insert_foot_bush(side == 0 ? "l_foot" : "r_foot", centred, &biped->robot);
    biped->feet[side] = static_cast<int>(biped->robot.tree.links.size()) - 1;
  }
  biped->sole_centre = Vector3d(0, 0, biped->sole_half.z());
}

CornerFinder make_finder(const Biped& biped) {
  CornerFinder finder;
  for (int foot : biped.feet) finder.add_box(foot, biped.sole_half, biped.sole_centre);
  return finder;
}

Scenario make_biped_scenario() {
  Scenario scenario = make_scenario();
  scenario.servo_default.kp = 5000.0;
  scenario.servo_default.kd = 50.0;
  scenario.initial_position = Vector3d(0, 0, 0.8);
  scenario.feet = {"l_foot", "r_foot"};
  return scenario;
}

}  // namespace hrp::rigs
