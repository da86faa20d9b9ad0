// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/foot_bush.h"

#include "common/base/diagnostics.h"
#include "common/robot/sole.h"

namespace hrp {
namespace {

[[noreturn]] void fail(const std::string& foot, const std::string& message) {
  refuse_input({"", "foot_bush." + foot}, message);
}

int find_foot_link(const std::string& foot, const TreeSpec& tree) {
  const int frame = tree.find_frame(foot);
  const int link = frame >= 0 ? tree.frames[static_cast<size_t>(frame)].link : tree.find_link(foot);
  if (link < 0) fail(foot, "the robot has no such link");
  for (const LinkSpec& other : tree.links) {
    if (other.parent == link)
      fail(foot, "joint '" + other.joint.name + "' is below the foot: no bush can be put there");
  }
  return link;
}

Vector3d find_centre(int link, const FootBushSpec& spec, const RobotDescription& robot) {
  if (spec.center) return *spec.center;
  for (const Sole& sole : make_soles(robot)) {
    if (sole.link == link) return sole.p_LR;
  }
  return Vector3d::Zero();
}

struct BushJoint {
  const char* suffix;
  JointKind kind;
  Vector3d axis;
  double stiffness, damping, offset;
};

// A massless link moved by one joint of the bush.
LinkSpec make_link(const std::string& foot, const BushJoint& bush, int parent, const Vector3d& p_PF) {
  if (!(bush.stiffness > 0.0)) fail(foot, std::string("the stiffness of ") + bush.suffix + " must be positive");
  LinkSpec link;
  link.name = foot + bush.suffix;
  link.parent = parent;
  link.joint.name = foot + bush.suffix;
  link.joint.kind = bush.kind;
  link.joint.X_PF.p = p_PF;
  link.joint.axis_F = bush.axis;
  link.joint.actuated = false;
  link.joint.spring.stiffness = bush.stiffness;
  link.joint.spring.damping = bush.damping;
  link.joint.spring.rest = -bush.offset / bush.stiffness;
  return link;
}

}  // namespace

void insert_foot_bush(const std::string& foot, const FootBushSpec& spec, RobotDescription* robot) {
  TreeSpec& tree = robot->tree;
  const int upper = find_foot_link(foot, tree);
  if (!(spec.upper_mass_ratio >= 0.0 && spec.upper_mass_ratio < 1.0)) fail(foot, "upper_mass_ratio must be in [0, 1)");
  const Vector3d centre = find_centre(upper, spec, *robot);
  const BushJoint joints[3] = {
      {"_bush_z", JointKind::kPrismatic, Vector3d::UnitZ(), spec.kz, spec.cz, 0.0},
      {"_bush_roll", JointKind::kRevolute, Vector3d::UnitX(), spec.k_roll, spec.c_roll, spec.offset_roll},
      {"_bush_pitch", JointKind::kRevolute, Vector3d::UnitY(), spec.k_pitch, spec.c_pitch, spec.offset_pitch}};
  int parent = upper;
  for (const BushJoint& joint : joints) {
    tree.links.push_back(make_link(foot, joint, parent, parent == upper ? centre : Vector3d(Vector3d::Zero())));
    parent = static_cast<int>(tree.links.size()) - 1;
  }
  LinkSpec& sole = tree.links.back();
  LinkInertia& above = tree.links[static_cast<size_t>(upper)].inertia;
  const double lower_share = 1.0 - spec.upper_mass_ratio;
  sole.name = foot + "_sole";
  sole.inertia.mass = lower_share * above.mass;
  sole.inertia.p_LLcm_L = above.p_LLcm_L - centre;
  sole.inertia.I_LLcm_L = lower_share * above.I_LLcm_L;
  above.mass *= spec.upper_mass_ratio;
  above.I_LLcm_L *= spec.upper_mass_ratio;
  tree.frames.push_back({sole.name, parent, Transform{}});
  const auto move = [&](CollisionShape* shape) {
    if (shape->link != upper) return;
    shape->link = parent;
    shape->X_LG.p -= centre;
  };
  for (CollisionShape& shape : robot->shapes) move(&shape);
  for (VisualShape& visual : robot->visuals) move(&visual.shape);
}

void insert_foot_bushes(const Scenario& scenario, RobotDescription* robot) {
  if (scenario.contact.model == "wrench") return;  // there the rubber is the law of the foot's pairs
  for (const auto& [foot, spec] : scenario.foot_bush) insert_foot_bush(foot, spec, robot);
}

}  // namespace hrp
