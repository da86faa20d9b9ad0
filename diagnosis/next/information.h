// SPDX-License-Identifier: BSD-3-Clause
// Information that a motion is expected to give, before it is played. All differences of readings are in units of
// noise. Sums over motions add, so a set of motions is judged as fast as one.
#pragma once

#include <Eigen/Dense>

namespace hrp::diagnosis {

// Compares one explanation with another one as the truth, over some recordings. r: difference of their predictions; J:
// derivatives of r with respect to the explanation's p parameters.
struct Comparison {
  double power = 0.0;      // r^T r
  Eigen::VectorXd along;   // J^T r
  Eigen::MatrixXd fisher;  // J^T J, Fisher information
  double count = 0.0;      // samples of all signals
};

// r^T r - (J^T r)^T A^-1 (J^T r), A = J^T J + `known`: the difference that remains if the explanation's parameters are
// fitted again. `known`: information of existing recordings.
double calc_projected_power(const Comparison& comparison, const Eigen::MatrixXd& known);

// Probability that a rival is rejected: its chi2 grows by more than `needed` beyond the noise. `left`: as above.
// `discrepancy` >= 1: rms residual [noise] of the best explanation in existing recordings. `needed` <= 0: rejected in
// any case.
double calc_decision_probability(double left, double needed, double discrepancy);

// Standard deviations of parameters from Fisher information; `largest` for parameters without information [each in its
// unit].
Eigen::VectorXd calc_expected_std(const Eigen::MatrixXd& fisher, const Eigen::VectorXd& largest);

// Factor on Fisher information if models leave more than noise. The residual is correlated over a stretch, so a
// recording of `count` samples has about `stretches` independent ones.
double calc_information_factor(double discrepancy, double count, double stretches);

}  // namespace hrp::diagnosis
