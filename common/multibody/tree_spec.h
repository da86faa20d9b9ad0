// SPDX-License-Identifier: BSD-3-Clause
// Description of a tree of rigid bodies: what a loader produces, what Model (model.h) is made from.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "common/spatial/transform.h"

namespace hrp {

// Mass properties of link L.
struct LinkInertia {
  double mass = 0.0;                     // [kg]
  Vector3d p_LLcm_L = Vector3d::Zero();  // [m] centre of mass
  Matrix3d I_LLcm_L = Matrix3d::Zero();  // [kg m^2] about the centre of mass, link axes
};

enum class JointKind { kRevolute, kPrismatic };  // a continuous joint is a revolute one without position limits

// A joint that follows another one: q = multiplier q_followed + offset.
struct MimicSpec {
  int joint = -1;  // index of the followed joint, -1 for none
  double multiplier = 1.0;
  double offset = 0.0;  // [rad or m]
};

// Passive spring and damper: effort = -stiffness (q - rest) - damping qd.
struct JointSpring {
  double stiffness = 0.0;  // [N m/rad or N/m]
  double damping = 0.0;    // [N m s/rad or N s/m]
  double rest = 0.0;       // [rad or m]
};

struct JointSpec {
  std::string name;
  JointKind kind = JointKind::kRevolute;
  Transform X_PF;                       // joint frame F in the parent link; child frame = F at q = 0
  Vector3d axis_F = Vector3d::UnitZ();  // unit vector
  double lower = -std::numeric_limits<double>::infinity();  // [rad or m]
  double upper = std::numeric_limits<double>::infinity();
  double effort_limit = std::numeric_limits<double>::infinity();    // [N m or N]
  double velocity_limit = std::numeric_limits<double>::infinity();  // [rad/s or m/s]
  double rotor_inertia = 0.0;                                       // [kg m^2 or kg] reflected
  double viscous_friction = 0.0;                                    // [N m s/rad or N s/m]
  double coulomb_friction = 0.0;                                    // [N m or N]
  bool actuated = true;
  MimicSpec mimic;
  JointSpring spring;
};

// Link i > 0 moves by `joint` against links[parent]; parent < i. Link 0 is the base, its joint is not used.
struct LinkSpec {
  std::string name;
  int parent = -1;
  LinkInertia inertia;
  JointSpec joint;
};

// A named frame fixed to a moving link. Every URDF link is one, lumped or not.
struct FrameSpec {
  std::string name;
  int link = 0;
  Transform X_LF;
  // Of this URDF link and of all that is fixed to it, frame axes: what a force sensor at the frame has below it.
  LinkInertia below{};
};

struct TreeSpec {
  std::string name;
  bool floating_base = true;  // false: the base is welded to the world at the initial pose
  std::vector<LinkSpec> links;
  std::vector<FrameSpec> frames;

  int num_joints() const { return static_cast<int>(links.size()) - 1; }
  // Joint i, which moves link i + 1.
  const JointSpec& joint(int i) const { return links[static_cast<size_t>(i) + 1].joint; }
  JointSpec& joint(int i) { return links[static_cast<size_t>(i) + 1].joint; }
  // Indices by name, -1 when there is none.
  int find_link(const std::string& name) const;
  int find_joint(const std::string& name) const;
  int find_frame(const std::string& name) const;
};

}  // namespace hrp
