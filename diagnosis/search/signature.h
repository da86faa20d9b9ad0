// SPDX-License-Identifier: BSD-3-Clause
// Signatures of effects in the equation error, as columns of a whitened regression. Rows by sample and joint: (1)
// logged effort - effort of the motion, (2) logged effort - effort by the servo law.
#pragma once

#include <functional>

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis {

// An effect at one place with fixed shape (Stribeck velocity, yield angle); its coefficients are linear in the
// residual.
struct Shape {
  EffectId id;
  Place place;
  std::vector<int> columns;
  // Converts coefficients to parameters; returns false if their signs are not physical.
  std::function<bool(const std::vector<double>& x, std::vector<double>* p)> make_start;
};

// Normal equations of all shapes.
struct Signatures {
  std::vector<Shape> shapes;
  Eigen::MatrixXd gram;        // of the whitened columns
  Eigen::VectorXd projection;  // of the whitened residual on the columns
  double chi2 = 0.0, count = 0.0;
  std::vector<double> joint_chi2;
};

// Signatures in the residual of the nominal model with the laws of `base`, along `paths` under `base` (null: as
// recorded).
Signatures calc_signatures(const Problem& problem, const Hypothesis& base, const Paths* paths = nullptr);

}  // namespace hrp::diagnosis
