// SPDX-License-Identifier: BSD-3-Clause
// What a motion is expected to tell, before it is played. Everything is in units of noise: differences of readings over
// the noise's standard deviation. Sums over motions add, so that a set of motions is judged as quickly as one.
#pragma once

#include <Eigen/Dense>

namespace hrp::diagnosis {

constexpr double kValues = 0.5;  // worth of halved intervals beside that of a certain decision

// One explanation against the truth of another, over some recordings: r is the difference of their predictions, J its
// slopes over the explanation's p parameters.
struct Comparison {
  double power = 0.0;       // r^T r
  Eigen::VectorXd along;    // J^T r
  Eigen::MatrixXd fisher;   // J^T J, Fisher information
  double count = 0.0;       // samples of all signals
  void add(const Comparison& other);
};

// r^T r - (J^T r)^T A^-1 (J^T r), A = J^T J + `known`: what is left of the difference when the explanation's parameters
// are fitted again. `known` is the information of recordings that exist already.
double calc_projected_power(const Comparison& comparison, const Eigen::MatrixXd& known);

// Probability that a rival is given up: that its chi2 grows by more than `needed` over the noise. `left` as above;
// `discrepancy` >= 1 is the root mean square that the best explanation leaves of recordings that exist, in noise
// deviations. `needed` <= 0: it is given up whatever the motion shows.
double calc_decision_probability(double left, double needed, double discrepancy);

// Standard deviations of parameters from Fisher information; `largest` where there is none [each in its unit].
Eigen::VectorXd calc_expected_std(const Eigen::MatrixXd& fisher, const Eigen::VectorXd& largest);

// Factor of Fisher information where models leave more than noise: what is left repeats over a stretch, and a recording
// of `count` samples has about `stretches` independent ones.
double calc_information_factor(double discrepancy, double count, double stretches);

}  // namespace hrp::diagnosis
