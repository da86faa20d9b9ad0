// SPDX-License-Identifier: BSD-3-Clause
// Fitting hypotheses to the channels of the training recordings.
//
// Noise in what a residual is differentiated by (a moment, a rate) biases plain least squares: what is fitted to noise
// looks smaller than it is, and neighbours make up for it. polish() is an instrumental-variable estimator: every
// recording is smoothed twice more, from its even and from its odd samples, whose noise is independent, and each half's
// columns are the instruments of the other. With J, r of the two halves,
//   (Je^T Jo + Jo^T Je) delta = -(Je^T ro + Jo^T re)
// has no product of a noise with itself in it: the estimate is consistent whatever the noise, and about as precise.
#pragma once

#include <Eigen/Dense>

#include "diagnosis/estimate/significance.h"
#include "diagnosis/standing/channels.h"
#include "diagnosis/standing/effects.h"

namespace hrp::diagnosis::standing {

constexpr double kStretch = 0.5;      // [s] errors of stretches this long are taken as independent

using Evaluation = std::vector<StandBase>;            // by recording
using Derivative = std::vector<std::vector<double>>;  // by recording, flat as the residuals

struct StandStep {
  Eigen::VectorXd delta;
  Eigen::MatrixXd covariance;
  bool ok = false;
};

struct StandProblems {
  StandProblem all, even, odd;
  StandProblem wide_even, wide_odd;  // the same smoothed more: what fast motion loses by smoothing
};

// What is fitted to: recordings, and a weight for each channel.
struct FitSelection {
  std::vector<size_t> recordings;
  std::vector<double> weight;
};

Evaluation evaluate(const StandProblem& problem, const Hypothesis& hypothesis);

// Derivatives over the parameters of effects [first, end) of the hypothesis, whose evaluation is `base`, for the given
// recordings (empty for the others). Those that are read off and not fitted have a zero column.
std::vector<Derivative> differentiate(const StandProblem& problem, const Hypothesis& hypothesis, size_t first,
                                      const Evaluation& base, const std::vector<size_t>& recordings);

// Columns of the shared part of many fits, weighted, over the selected recordings: found once.
struct SharedColumns {
  std::vector<Derivative> columns;
  Eigen::MatrixXd weighted;  // row by selected residual
  Eigen::VectorXd residual;
};
SharedColumns share_columns(const FitSelection& selection, std::vector<Derivative> columns, const Evaluation& base);

// Gauss-Newton step of the shared columns and `added` together; no covariance. Both sides the same: plain least
// squares.
struct ColumnSide {
  const SharedColumns& shared;
  const std::vector<Derivative>& added;
};
Eigen::VectorXd solve_with(const StandProblem& problem, const FitSelection& selection,
                           const Hypothesis& hypothesis, const ColumnSide& x, const ColumnSide& y);

// Gauss-Newton step of plain least squares, with what is known beforehand.
StandStep solve(const StandProblem& problem, const FitSelection& selection, const Hypothesis& hypothesis,
                const std::vector<Derivative>& columns, const Evaluation& base);

// Refines a hypothesis by plain least squares.
Hypothesis refine(const StandProblem& problem, const FitSelection& selection, Hypothesis hypothesis,
                       int iterations);

// The same by instrumental variables, with the robust covariance over stretches (estimate/robust.h), so that errors that
// last count as what they are. False when it does not settle.
bool polish(const StandProblems& problems, const FitSelection& selection, int iterations, Hypothesis* hypothesis,
            Eigen::MatrixXd* covariance);

// Adds a step to the parameters of effects [first, end). A shape, or a damping, that the data hardly see may be thrown
// far by one step: it stays within its bounds, so that the effect is not given up for it.
void add_step(const Eigen::VectorXd& delta, size_t first, Hypothesis* hypothesis);

}  // namespace hrp::diagnosis::standing
