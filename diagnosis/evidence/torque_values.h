// SPDX-License-Identifier: BSD-3-Clause
// A term's coefficients as parameters of its row in the table of effects.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "diagnosis/measurement/torque_terms.h"

namespace hrp::diagnosis {

// Of the row's first parameters, in its order and units at a joint that turns.
struct TermValues {
  std::vector<double> value, std;
};

// From coefficients p with standard deviations s. Not for a Stribeck excess, which is no effect alone.
TermValues calc_values(const Term& term, const Eigen::VectorXd& p, const Eigen::VectorXd& s);

}  // namespace hrp::diagnosis
