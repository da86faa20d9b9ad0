// SPDX-License-Identifier: BSD-3-Clause
// Zero-phase low-pass filtering of evenly sampled series.
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace hrp::diagnosis {

// A series on an even grid of `count` samples from `begin` [s], `step` [s] apart; linear between samples, NaN skipped.
Eigen::VectorXd resample(const std::vector<double>& time, const std::vector<double>& values, double begin, double step,
                         long count);

// Butterworth, order 2, forward and backward: order 4, -6 dB at `cutoff` [Hz], no phase. The ends are continued by
// their point reflections over two periods of the cutoff. A cutoff above 0.4 of the sampling rate changes nothing.
Eigen::VectorXd low_pass(const Eigen::VectorXd& series, double step, double cutoff);

// Central differences, one-sided at the ends.
Eigen::VectorXd differentiate(const Eigen::VectorXd& series, double step);

}  // namespace hrp::diagnosis
