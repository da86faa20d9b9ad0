// SPDX-License-Identifier: BSD-3-Clause
// Recursive Newton-Euler: which generalised force a motion takes.
#pragma once

#include <vector>

#include "common/multibody/model.h"

namespace hrp {

// External wrench on every link: [moment about the link's origin; force], world axes. Empty or nullptr: none.
using LinkWrenches = std::vector<Vector6d, Eigen::aligned_allocator<Vector6d>>;

// A wrench about Q, moved to the link's origin.
Vector6d calc_wrench_about_origin(const Data& data, int link, const Vector3d& p_WQ, const Vector6d& F_Q_W);

// tau = M vdot + C v + g - J^T F: [moment about B's origin; force on B; joint efforts], rotor inertia included.
// Needs update_kinematics. tau must have size nv. NaN in the input gives NaN in the output.
void calc_inverse_dynamics(const Model& model, const Eigen::VectorXd& vdot, const LinkWrenches* wrenches, Data* data,
                           Eigen::VectorXd* tau);

// C v + g: inverse dynamics at vdot = 0.
void calc_bias(const Model& model, Data* data, Eigen::VectorXd* bias);

// After calc_inverse_dynamics: wrench that the joint of `link` passes from the parent to the link, [moment about the
// link's origin; force], world axes. Base: what the world would have to add.
Vector6d get_joint_wrench(const Data& data, int link);

}  // namespace hrp
