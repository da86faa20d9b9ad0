// SPDX-License-Identifier: BSD-3-Clause
// What legs that stand tell of the ground where no sensor feels it: their joints' torques.
//
// About a floating base, y = torques less inverse dynamics without the ground. At the true model the ground's forces f
// [N], of flat soles moments [N m], too, make the rest of it: y_leg = -A f, y_base = -B f, with A = J^T of the legs'
// joints and B that of the base. So f = -A^+ y_leg, and y_base - B A^+ y_leg = 0: six relations between torques, IMU,
// encoders and masses that no unknown force is in (Featherstone, Rigid Body Dynamics Algorithms, 2008, section 9.5).
#pragma once

#include "diagnosis/floating/equations/residuals.h"

namespace hrp::diagnosis::floating {

// B A^+ [6 x joints] of the six equations of the base, moments first, for legs with the rows A [joints x forces] and
// B [6 x forces]. Empty: fewer joints than forces, or a leg so straight that its torques do not tell a force along it.
// `reach` [m]: the lever of such a force.
Eigen::MatrixXd calc_share_of_base(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, double reach);

// Joints of a log whose torques carry a foot that no sensor feels, by joint.
std::vector<char> list_legs_that_tell(const LeggedLog& log);

// The matrix above at a sample, by joint, zero for joints that carry nothing. Empty: it is not known there.
Eigen::MatrixXd find_leg_shares(const BodySample& at, const Contacts& contacts);

}  // namespace hrp::diagnosis::floating
