// SPDX-License-Identifier: BSD-3-Clause
// Zero-phase low-pass filter for uniformly sampled series.
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace hrp::diagnosis {

// Resamples a series to a uniform grid of `count` samples from `begin` [s] with `step` [s]; linear between samples, NaN
// skipped.
Eigen::VectorXd resample(const std::vector<double>& time, const std::vector<double>& values, double begin, double step,
                         long count);

// Butterworth filter of order 2, forward and backward: order 4, -6 dB at `cutoff` [Hz], no phase shift. The ends are
// extended by point reflection over two periods of the cutoff. A cutoff above 0.4 of the sampling rate has no effect.
Eigen::VectorXd low_pass(const Eigen::VectorXd& series, double step, double cutoff);

// Derivative by central differences, one-sided at the ends.
Eigen::VectorXd differentiate(const Eigen::VectorXd& series, double step);

}  // namespace hrp::diagnosis
