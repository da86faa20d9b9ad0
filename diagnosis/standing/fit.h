// SPDX-License-Identifier: BSD-3-Clause
// Fits hypotheses to the channels of the training recordings.
//
// Regressors contain noise (of a moment, a rate). Plain least squares then underestimates their parameters, and
// correlated parameters compensate (errors in variables). polish() is an instrumental-variable estimator. Each
// recording is smoothed twice more, from its even and from its odd samples, whose noise is independent. The columns of
// each half are the instruments of the other. With J, r of the two halves,
//   (Je^T Jo + Jo^T Je) delta = -(Je^T ro + Jo^T re)
// contains no product of a noise with itself. The estimate is consistent for any noise and about as precise.
#pragma once

#include <Eigen/Dense>

#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/standing/channels.h"
#include "diagnosis/standing/effects.h"

namespace hrp::diagnosis::standing {

using Evaluation = std::vector<StandBase>;            // by recording
using Derivative = std::vector<std::vector<double>>;  // by recording, flat as the residuals

// A Gauss-Newton step with its covariance; `ok`: all values are finite.
struct StandStep {
  Eigen::VectorXd delta;
  Eigen::MatrixXd covariance;
  bool ok = false;
};

// The same recordings, smoothed from all, from even and from odd samples.
struct StandProblems {
  StandProblem all, even, odd;
  StandProblem wide_even, wide_odd;  // the same with wider windows: shows what smoothing removes from fast motion
};

// Recordings that are fitted, and the weight of each channel [1 / noise].
struct FitSelection {
  std::vector<size_t> recordings;
  std::vector<double> weight;
};

// Residuals of all recordings under a hypothesis.
Evaluation evaluate(const StandProblem& problem, const Hypothesis& hypothesis);

// Derivatives with respect to the parameters of the effects [first, end) of the hypothesis, for the given recordings
// (empty for others). `base` is the evaluation of the hypothesis. Parameters that are read off, not fitted, have a zero
// column.
std::vector<Derivative> differentiate(const StandProblem& problem, const Hypothesis& hypothesis, size_t first,
                                      const Evaluation& base, const std::vector<size_t>& recordings);

// Weighted columns of the effects that many trial fits share, over the selected recordings. Computed once.
struct SharedColumns {
  std::vector<Derivative> columns;
  Eigen::MatrixXd weighted;  // row by selected residual
  Eigen::VectorXd residual;
};
SharedColumns share_columns(const FitSelection& selection, std::vector<Derivative> columns, const Evaluation& base);

// Gauss-Newton step of the shared columns and `added` together, without covariance. Equal sides x and y give plain
// least squares, the two halves give instrumental variables.
struct ColumnSide {
  const SharedColumns& shared;
  const std::vector<Derivative>& added;
};
Eigen::VectorXd solve_with(const StandProblem& problem, const FitSelection& selection, const Hypothesis& hypothesis,
                           const ColumnSide& x, const ColumnSide& y);

// Gauss-Newton step of plain least squares with the priors.
StandStep solve(const StandProblem& problem, const FitSelection& selection, const Hypothesis& hypothesis,
                const std::vector<Derivative>& columns, const Evaluation& base);

// Refines a hypothesis by plain least squares.
Hypothesis refine(const StandProblem& problem, const FitSelection& selection, Hypothesis hypothesis, int iterations);

// The same by instrumental variables, with the robust covariance over stretches (estimate/robust.h), which includes
// errors that last. Returns false if the fit does not converge to a physical hypothesis.
bool polish(const StandProblems& problems, const FitSelection& selection, int iterations, Hypothesis* hypothesis,
            Eigen::MatrixXd* covariance);

// Adds a step to the parameters of the effects [first, end). A step may move a poorly determined shape or damping
// parameter too far. Such parameters are limited to their bounds, so the effect stays a candidate.
void add_step(const Eigen::VectorXd& delta, size_t first, Hypothesis* hypothesis);

}  // namespace hrp::diagnosis::standing
