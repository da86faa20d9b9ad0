// SPDX-License-Identifier: BSD-3-Clause
// Fits all subsets of one joint's terms, beside given terms of the whole robot.
#pragma once

#include "diagnosis/evidence/torque/model.h"

namespace hrp::diagnosis {

// True if these terms of a joint may be in one model.
bool is_sensible(const JointDesign& joint, const std::vector<size_t>& terms);

// A subset of a joint's terms with its evidence.
struct Subset {
  std::vector<size_t> terms;
  double evidence = -1e300;
  std::vector<double> first;  // first parameter of each term
};

// Physical subsets, best first. `whole`: parameters of all columns of the whole robot's terms.
std::vector<Subset> list_subsets(const TorqueDesign& design, size_t joint, const Eigen::VectorXd& whole, Timing timing);

// Bayesian model averaging: posterior probability of each term, and the standard deviation of its first parameter over
// subsets.
void average(const std::vector<Subset>& subsets, std::vector<double>* inclusion, std::vector<double>* std);

}  // namespace hrp::diagnosis
