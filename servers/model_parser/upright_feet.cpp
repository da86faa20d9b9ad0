// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/upright_feet.h"

#include <cmath>
#include <vector>

namespace hrp {
namespace {

constexpr double kClear = 0.8;  // cosine, 37 degrees: an axis that leans more may be any of two

struct Links {
  std::map<std::string, Transform> X_BC;      // poses in the base
  std::map<std::string, std::string> moving;  // the link that a link is fixed to; itself, if it moves
};

// In the initial pose.
Links place_all(const urdf::ModelInterface& model, const UrdfScan& scan, const Scenario& scenario) {
  std::multimap<std::string, const JointScan*> children;
  for (const JointScan& joint : scan.joints) children.emplace(joint.parent, &joint);
  Links links;
  links.X_BC[scan.root] = Transform();
  links.moving[scan.root] = scan.root;
  std::vector<std::string> open{scan.root};
  while (!open.empty()) {
    const std::string parent = open.back();
    open.pop_back();
    const auto [begin, end] = children.equal_range(parent);
    for (auto it = begin; it != end; ++it) {
      const JointScan& joint = *it->second;
      const urdf::JointConstSharedPtr parsed = model.getJoint(joint.name);
      Transform X = links.X_BC[parent] * make_transform(parsed->parent_to_joint_origin_transform);
      const auto q = scenario.initial_joints.find(joint.name);
      const bool turns = joint.type == "revolute" || joint.type == "continuous";
      if (turns && q != scenario.initial_joints.end())
        X.R = X.R * Eigen::AngleAxisd(q->second, make_vector(parsed->axis).normalized()).toRotationMatrix();
      links.X_BC[joint.child] = X;
      links.moving[joint.child] = joint.type == "fixed" ? links.moving[parent] : joint.child;
      open.push_back(joint.child);
    }
  }
  return links;
}

// Legs that hang below the base say that its z axis is up.
bool hang_below(const Links& links, const std::vector<std::string>& feet) {
  Vector3d sum = Vector3d::Zero();
  for (const std::string& foot : feet) {
    const auto at = links.X_BC.find(foot);
    if (at != links.X_BC.end()) sum += at->second.p;
  }
  return -sum.z() > kClear * sum.norm();
}

// R_CL: z of L is the axis of C nearest to `up_C`. No turn if that is z, or if none is near.
Matrix3d find_turn(const Vector3d& up_C) {
  Eigen::Index axis = 0;
  const double most = up_C.cwiseAbs().maxCoeff(&axis);
  const Vector3d z_C = std::copysign(1.0, up_C[axis]) * Vector3d::Unit(axis);
  if (most < kClear || z_C.z() > 0.5) return Matrix3d::Identity();
  if (z_C.z() < -0.5) return Eigen::AngleAxisd(M_PI, Vector3d::UnitX()).toRotationMatrix();
  return Eigen::AngleAxisd(0.5 * M_PI, Vector3d::UnitZ().cross(z_C)).toRotationMatrix();
}

}  // namespace

std::map<std::string, Matrix3d> find_upright_feet(const urdf::ModelInterface& model, const UrdfScan& scan,
                                                  const Scenario& scenario) {
  std::map<std::string, Matrix3d> turned;
  if (!scenario.floating_base || scenario.feet.empty()) return turned;
  const Links links = place_all(model, scan, scenario);
  if (!hang_below(links, scenario.feet)) return turned;
  for (const std::string& foot : scenario.feet) {
    const auto moving = links.moving.find(foot);
    if (moving == links.moving.end() || moving->second == scan.root) continue;
    const Matrix3d R_CL = find_turn(links.X_BC.at(moving->second).R.row(2).transpose());
    if (!R_CL.isIdentity(0.0)) turned[moving->second] = R_CL.array().round().matrix();
  }
  return turned;
}

}  // namespace hrp
