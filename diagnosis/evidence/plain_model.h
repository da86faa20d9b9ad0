// SPDX-License-Identifier: BSD-3-Clause
// What anybody would do first: plain linear least squares of viscous and Coulomb friction and rotor inertia at every driven
// joint (Gautier and Khalil's inverse dynamic identification in its simplest form). To compare with, and a model that the
// tool's own must not fall behind.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {

// By joint: viscous friction [N m s/rad], Coulomb friction [N m], rotor inertia [kg m^2], none negative.
std::vector<Eigen::Vector3d> fit_plain_model(const Problem& problem);

Hypothesis make_plain_model(const std::vector<Eigen::Vector3d>& fitted);

}  // namespace hrp::diagnosis
