// SPDX-License-Identifier: BSD-3-Clause
// Normal equations of effects' coefficients: what is known of them beforehand, and their solution. Private to the fit
// (least_squares.h). Coefficients stand in the order of the effects; each has the unit of its effect's parameter.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "diagnosis/floating/fit/candidates.h"

namespace hrp::diagnosis::floating {

// Of the diagonal: keeps columns that are exactly alike solvable, and moves no other coefficient by more than rounding
// does.
constexpr double kRidge = 1e-9;

long count_coefficients(const std::vector<Candidate>& effects);

// Solves A x = b with each column scaled to a diagonal of one, plus `ridge` on it. NaN where a diagonal is not
// positive.
Eigen::VectorXd solve_scaled(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, double ridge = kRidge);

// Adds what is known of coefficients beforehand to their normal equations, from coefficient `first` on. A column that
// is noise alone tells nothing: only that stays.
void add_prior(const std::vector<double>& prior, long first, Eigen::MatrixXd* A, Eigen::VectorXd* b);
void add_priors(const std::vector<Candidate>& effects, Eigen::MatrixXd* A, Eigen::VectorXd* b);

}  // namespace hrp::diagnosis::floating
