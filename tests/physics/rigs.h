// SPDX-License-Identifier: BSD-3-Clause
// Small robots and a corner-against-plane contact finder for tests of the physics core (no FCL needed).
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "common/multibody/model.h"
#include "servers/dynamics/simulator.h"

namespace hrp::rigs {

inline LinkInertia make_box_inertia(double mass, const Vector3d& size, const Vector3d& com = Vector3d::Zero()) {
  const Vector3d s = size.cwiseProduct(size);
  LinkInertia inertia;
  inertia.mass = mass;
  inertia.p_LLcm_L = com;
  inertia.I_LLcm_L = (mass / 12.0 * Vector3d(s.y() + s.z(), s.x() + s.z(), s.x() + s.y())).asDiagonal();
  return inertia;
}

inline RobotDescription make_body(const LinkInertia& inertia) {
  RobotDescription robot;
  robot.tree.name = "body";
  robot.tree.links.resize(1);
  robot.tree.links[0].name = "body";
  robot.tree.links[0].inertia = inertia;
  return robot;
}

// Adds a link and returns its index. The joint frame has the parent's axes.
inline int add_link(RobotDescription* robot, const std::string& name, int parent, const Vector3d& p_PF,
                    const Vector3d& axis, const LinkInertia& inertia) {
  LinkSpec link;
  link.name = name;
  link.parent = parent;
  link.inertia = inertia;
  link.joint.name = name + "_joint";
  link.joint.X_PF.p = p_PF;
  link.joint.axis_F = axis;
  robot->tree.links.push_back(link);
  return static_cast<int>(robot->tree.links.size()) - 1;
}

// Corners of box soles, found against the ground plane of the scenario.
struct CornerFinder {
  struct Corner {
    int link = 0;
    Vector3d p_LC;
  };
  std::vector<Corner> corners;
  Vector3d n = Vector3d::UnitZ();
  double height = 0.0;
  double margin = 0.0;  // corners this far above count, too (ContactSpec::margin)
  double friction = 0.8;

  void add_box(int link, const Vector3d& half, const Vector3d& centre = Vector3d::Zero()) {
    for (double x : {-1.0, 1.0}) {
      for (double y : {-1.0, 1.0}) corners.push_back({link, centre + Vector3d(x * half.x(), y * half.y(), -half.z())});
    }
  }
  ContactSet find(const Model& model, const State& state) const;
};

inline Scenario make_scenario() {
  Scenario scenario;
  scenario.initial_height_given = true;
  scenario.control_period = 1;
  scenario.ground.present = false;
  return scenario;
}

// A biped of 58 kg: trunk, two legs of hip pitch, knee, ankle pitch, ankle roll, feet of 1 kg with box soles. Origin in
// the trunk, 0.8 m above the soles with straight legs.
struct Biped {
  RobotDescription robot;
  int feet[2] = {0, 0};  // links that carry the soles
  Vector3d sole_half = Vector3d(0.12, 0.065, 0.02);
  Vector3d sole_centre = Vector3d(0.015, 0.0, -0.085);  // in the foot link; lower face 0.105 m below the ankle
};
Biped make_biped();
// Bushes in both feet; the soles are then links of their own.
void add_bushes(const FootBushSpec& spec, Biped* biped);
CornerFinder make_finder(const Biped& biped);
Scenario make_biped_scenario();

inline JointCommand make_command(const State& state) {
  JointCommand command;
  command.q = state.q;
  return command;
}

}  // namespace hrp::rigs
