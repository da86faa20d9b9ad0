// SPDX-License-Identifier: BSD-3-Clause
// What sensors say less what the motion takes, at a sample, by row (body_channels.h).
#pragma once

#include "diagnosis/floating/equations/body_channels.h"
#include "diagnosis/floating/equations/joint_turns.h"

namespace hrp::diagnosis::floating {

struct BodyResiduals {
  Eigen::VectorXd y, measured;  // by row: residual, and its measured part [N, N m]
  Eigen::VectorXd tau;          // of inverse dynamics without the ground [N, N m], by velocity of the model
  Eigen::VectorXd load;         // by joint: what the link takes of its joint [N m]
};

// `normal`: of the ground, base axes, for the weight. Leaves accelerations and joint wrenches in the motion's data.
BodyResiduals calc_residuals(const BodySample& at, const BodyChannels& channels, const Vector3d& normal);

// [N m] The torque of a joint by its servo law. `rate`: the rate of the part that follows from the command [N m/s].
double calc_servo_law(const BodySample& at, size_t joint, double* rate);

// How far the encoder's side of each transmission is ahead of the link's, by what the link takes of the joint.
std::vector<JointSides> find_sides(const BodySample& at, const Eigen::VectorXd& load);

// Calls put(row, value) for each equation that a wrench on a link is in. Joints between the link and the base see it.
template <class Put>
void project(const BodySample& at, const BodyChannels& channels, const Vector3d& normal, const PointWrench& w,
             double sign, const Put& put) {
  const Vector3d about = w.moment + w.p.cross(w.force);
  for (int i = 0; i < 6 && channels.balances; ++i) put(i, sign * (i < 3 ? about(i) : w.force(i - 3)));
  if (channels.weighs) put(kWeightRow, sign * normal.dot(w.force));
  for (int l = w.whole ? w.link : 0; l > 0; l = at.log.tree.links[static_cast<size_t>(l)].parent) {
    const LinkKinematics& link = at.motion.data().kinematics[static_cast<size_t>(l)];
    const Vector3d axis = small::to_eigen(link.axis);
    const bool turns = at.log.tree.joint(l - 1).kind == JointKind::kRevolute;
    const Vector3d arm = w.p - small::to_eigen(link.p);
    put(kJointRow + l - 1, sign * (turns ? axis.dot(w.moment + arm.cross(w.force)) : axis.dot(w.force)));
  }
}

}  // namespace hrp::diagnosis::floating
