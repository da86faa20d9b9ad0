// SPDX-License-Identifier: BSD-3-Clause
// Equations of motion, linear in their parameters, as used to identify robots: Mikami et al. 2014 [M14].
//
//   [tau_base ]   [Y_BI  0   ] [phi_I]
//   [tau_joint] = [Y_JI  Y_JJ] [phi_J]                                                        [M14 eq. 1]
//
// tau_base: moment about the base's origin and force that the base needs from outside (ground, or what it is bolted
// to), world axes. tau_joint: what the drives deliver, friction and rotor included.
#pragma once

#include "common/multibody/model.h"

namespace hrp {

// Ten parameters a link: m, m c (3), I about the link's origin xx xy xz yy yz zz; link axes.
constexpr int kInertialParameters = 10;
// Three parameters a joint: rotor inertia, viscous friction, Coulomb friction.
constexpr int kJointParameters = 3;

struct Regressor {
  explicit Regressor(const Model& model);
  Eigen::MatrixXd Y_BI;  // 6 x 10 links, also for a fixed base: its reaction
  Eigen::MatrixXd Y_JI;  // n x 10 links
  Eigen::MatrixXd Y_JJ;  // n x 3 n
};

Eigen::VectorXd make_inertial_parameters(const Model& model);  // phi_I of the model
Eigen::VectorXd make_joint_parameters(const Model& model);     // phi_J of the model

// Needs update_kinematics. The sign of a velocity that is exactly zero is zero.
void calc_regressor(const Model& model, const Eigen::VectorXd& vdot, Data* data, Regressor* regressor);

}  // namespace hrp
