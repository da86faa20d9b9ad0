// SPDX-License-Identifier: BSD-3-Clause
// A motion that could be proposed, with the data for its worth.
#pragma once

#include <memory>
#include <numeric>
#include <vector>

#include "diagnosis/next/explanations.h"
#include "diagnosis/next/information.h"
#include "diagnosis/next/motions.h"

namespace hrp::diagnosis {

// A motion with its commands and its comparisons.
struct MotionCandidate {
  MotionPlan plan;
  Commands commands;
  std::vector<Comparison> comparisons;  // by explanation, the best one as truth; the first: its own information
  std::string fault;                    // of the last size that was tried
  bool ok = false;
};

// Scalar product of two series of the same length.
inline double dot(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

// Fisher information of recordings about the parameters of an explanation, along the recorded paths.
Eigen::MatrixXd calc_fisher(const Problem& problem, const Hypothesis& hypothesis, const std::vector<int>& recordings,
                            double discrepancy);

// Compares every explanation with the best one along this motion. `rate`: recorder samples per sample of the motion.
void compare(const Problem& problem, const Explanations& explanations, double rate, MotionCandidate* candidate);

}  // namespace hrp::diagnosis
