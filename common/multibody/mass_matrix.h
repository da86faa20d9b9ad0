// SPDX-License-Identifier: BSD-3-Clause
// Composite rigid bodies: the mass matrix.
#pragma once

#include "common/multibody/model.h"

namespace hrp {

// M (nv x nv, both triangles), rotor inertias on the diagonal, into data->M, which is also returned. Needs
// update_kinematics. Entries between different branches are zero from construction on and never touched.
const Eigen::MatrixXd& update_mass_matrix(const Model& model, Data* data);

}  // namespace hrp
