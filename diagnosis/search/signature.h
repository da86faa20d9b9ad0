// SPDX-License-Identifier: BSD-3-Clause
// Signatures of effects in the equation error, as columns of a whitened regression. Rows: for every kept sample and
// joint, (1) logged effort - effort that the motion takes, (2) logged effort - effort the servo should have asked for.
#pragma once

#include <functional>

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis {

// One effect at one place with its shape fixed (a Stribeck velocity, a yield angle): linear in what is left.
struct Shape {
  EffectId id;
  Place place;
  std::vector<int> columns;
  // Parameters of the effect from the coefficients; false when their signs make no sense.
  std::function<bool(const std::vector<double>& x, std::vector<double>* p)> make_start;
};

struct Signatures {
  std::vector<Shape> shapes;
  Eigen::MatrixXd gram;          // of the whitened columns
  Eigen::VectorXd projection;    // of the whitened residual on them
  double chi2 = 0.0, count = 0.0;
  std::vector<double> joint_chi2;
};

// The residual is taken against the nominal model with `base` added where base's laws act on efforts, along `paths`
// under `base` (null: as recorded).
Signatures calc_signatures(const Problem& problem, const Hypothesis& base, const Paths* paths = nullptr);

}  // namespace hrp::diagnosis
