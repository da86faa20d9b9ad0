// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/multibody/tree_spec.h"

namespace hrp {

// X_FC: pose of the child link in its joint's frame, at position q [rad or m].
inline Transform calc_joint_motion(const JointSpec& joint, double q) {
  if (joint.kind == JointKind::kPrismatic) return {Matrix3d::Identity(), q * joint.axis_F};
  return {Eigen::AngleAxisd(q, joint.axis_F).toRotationMatrix(), Vector3d::Zero()};
}

}  // namespace hrp
