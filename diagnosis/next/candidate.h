// SPDX-License-Identifier: BSD-3-Clause
// One motion that could be proposed, with everything its worth is computed from.
#pragma once

#include <memory>
#include <vector>

#include "diagnosis/next/explanations.h"
#include "diagnosis/next/information.h"
#include "diagnosis/next/motions.h"

namespace hrp::diagnosis {

struct MotionCandidate {
  MotionPlan plan;
  Commands commands;
  std::vector<Comparison> comparisons;  // by explanation, against the best as truth; the first: the best's own Fisher information
  bool ok = false;
};

// Information that recordings hold about the parameters of an explanation, along the recorded paths.
Eigen::MatrixXd calc_fisher(const Problem& problem, const Hypothesis& hypothesis, const std::vector<int>& recordings, double discrepancy);

// Every explanation against the best along this motion. `rate`: samples of the recorder for one of the motion's.
void compare(const Problem& problem, const Explanations& explanations, double rate, MotionCandidate* candidate);

}  // namespace hrp::diagnosis
