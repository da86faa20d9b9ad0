// SPDX-License-Identifier: BSD-3-Clause
// Inertial parameters that bodies can have.
#pragma once

#include "common/multibody/regressor.h"

namespace hrp::identification {

using LinkParameters = Eigen::Matrix<double, kInertialParameters, 1>;

// Pseudo-inertia of a link's ten parameters: [tr(I)/2 1 - I, m c; (m c)^T, m] (Wensing, Kim, Slotine 2018): positive
// definite exactly when the parameters are those of a body.
Eigen::Matrix4d make_pseudo_inertia(const LinkParameters& phi);
LinkParameters get_parameters(const Eigen::Matrix4d& pseudo_inertia);

// Smallest eigenvalue over the largest of any link's pseudo-inertia: positive for bodies.
double calc_smallest_eigenvalue(const Eigen::VectorXd& phi);

// A description that is wrong: each link's body stretched, moved and made denser at random (its pseudo-inertia goes to
// D P D^T, D = 1 + size x noise), so that it stays a body.
Eigen::VectorXd distort_bodies(const Eigen::VectorXd& phi, double size, unsigned long long seed);

// What is known before data: parameters and their precision.
struct BodyPrior {
  Eigen::VectorXd mean, precision;
};
// The description is right to the share `trust` of each link's own scale (mass, mass x length, mass x length^2).
BodyPrior make_body_prior(const Eigen::VectorXd& description, double trust);

// The bodies that fit best: min x'Ax/2 - b'x + prior, every link's pseudo-inertia inside the cone of bodies, by
// alternating directions (Boyd et al. 2011).
Eigen::VectorXd solve_bodies(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, const BodyPrior& prior);

}  // namespace hrp::identification
