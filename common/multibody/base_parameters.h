// SPDX-License-Identifier: BSD-3-Clause
// Which inertial parameters show at all: the smallest set whose combinations explain every motion of a tree.
#pragma once

#include <vector>

#include "common/multibody/regressor.h"

namespace hrp {

// Which rows of [M14 eq. 1] are looked at.
enum class RegressorRows { kBase, kJoints, kAll };

// phi_base = T phi_I explains the same as phi_I: Y phi_I = Y(:, independent) T phi_I for every motion.
struct BaseParameters {
  std::vector<int> independent;  // columns of Y that are kept, ascending
  std::vector<int> dependent;    // columns that are zero or combinations of kept ones, ascending
  Eigen::MatrixXd T;             // independent x 10 links
};

// Numerically, from random motions (fixed seed): QR without pivoting, where a column that depends on those before it
// leaves nothing on the diagonal (Gautier, Numerical calculation of the base inertial parameters, 1991). With a
// floating base, kBase alone finds what kAll finds (Ayusawa, Venture, Nakamura 2014): that is [M14 eq. 2]. A fixed base
// stands upright (R_WB = 1), and its own parameters are then told apart only as far as gravity shows them.
BaseParameters calc_base_parameters(const Model& model, RegressorRows rows, int num_motions = 0);

// Columns `independent` of Y.
Eigen::MatrixXd get_independent_columns(const BaseParameters& base, const Eigen::MatrixXd& Y);

}  // namespace hrp
