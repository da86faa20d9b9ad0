// SPDX-License-Identifier: BSD-3-Clause
// Articulated-body algorithm: accelerations from forces at a cost linear in the number of joints, with what a linearly
// implicit integrator adds on the left side, and many right-hand sides from one factorisation.
#pragma once

#include <vector>

#include "common/multibody/inverse_dynamics.h"

namespace hrp {

// A wrench on a link that falls with the link's acceleration: F = F0 - Z a, both about the link's origin in world axes,
// a = [alpha; acceleration of the origin] without gravity. F0 goes into the wrenches. Z symmetric: dt C + dt^2 K of a
// contact spring and damper in a linearly implicit step.
struct LinkImpedance {
  int link = 0;
  Matrix6d Z = Matrix6d::Zero();
};

using LinkImpedances = std::vector<LinkImpedance, Eigen::aligned_allocator<LinkImpedance>>;

// What is added on the left side: (M + diag(joint_inertia_extra) + sum J^T Z J) vdot = ...
struct ImplicitTerms {
  const Eigen::VectorXd* joint_inertia_extra = nullptr;  // [kg m^2 or kg] by joint: dt kd + dt^2 kp; nullptr: none
  const LinkImpedances* impedances = nullptr;            // nullptr: none
};

// vdot from the joints' efforts (size n) and wrenches on links. Needs update_kinematics. vdot must have size nv; it is
// written even when the status is not kOk, but then means nothing. Leaves the factorisation in data for the functions
// below.
Status calc_forward_dynamics(const Model& model, const Eigen::VectorXd& effort, const LinkWrenches* wrenches,
                             const ImplicitTerms& implicit, Data* data, Eigen::VectorXd* vdot);

// Marks `link` and every link that carries it, down to the base. marks: by link.
void mark_path(const Model& model, int link, std::vector<char>* marks);

// The same bits as calc_forward_dynamics, at less cost: since that (or this) function has seen `data`, nothing may have
// changed but wrenches and impedances of links for which mark_path() was called. Gathers marked links only.
Status recalc_forward_dynamics(const Model& model, const std::vector<char>& marks, const Eigen::VectorXd& effort,
                               const LinkWrenches* wrenches, const ImplicitTerms& implicit, Data* data,
                               Eigen::VectorXd* vdot);

// X = (M + ...)^-1 B, column by column, no velocity or gravity terms; X may not be B. Needs a factorisation (by one of
// the above) of the current positions.
void calc_responses(const Model& model, const Eigen::MatrixXd& B, Data* data, Eigen::MatrixXd* X);

}  // namespace hrp
