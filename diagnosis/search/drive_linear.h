// SPDX-License-Identifier: BSD-3-Clause
// Residuals of one joint and their slopes over parameters, and what follows from them without another simulation: how
// a model predicts stretches that it was not fitted to, and which parameters each part of the recordings asks for.
#pragma once

#include <Eigen/Dense>
#include <functional>

#include "diagnosis/search/fit.h"
#include "diagnosis/search/parameters.h"

namespace hrp::diagnosis {

using Slot = Parameter<EffectParameter>;

struct Linear {
  std::vector<int> recordings;
  std::vector<Eigen::VectorXd> r;  // by recording: whitened residuals [sample * kQuantities + quantity] of the view
  std::vector<Eigen::MatrixXd> J;  // dr / dparameter, by slot
  Eigen::VectorXd width;           // by slot: how far a parameter may reasonably move
  bool ok = false;
};

// Parameters that vary smoothly: all but scanned ones.
std::vector<Slot> list_slots(const Hypothesis& hypothesis);

// The problem's view must be of one joint, or of a robot of one joint.
Linear linearise(const Problem& problem, const Hypothesis& hypothesis, const std::vector<Slot>& slots,
                 const std::vector<int>& recordings);

// The same with the parameters of one more effect as further columns; not ok when it cannot be simulated.
Linear extend(const Problem& problem, const Linear& linear, const Hypothesis& model, const Effect& candidate);

// Sums over the samples of a group: G = J^T J, b = J^T r, c = r^T r.
struct Sums {
  Eigen::MatrixXd G;
  Eigen::VectorXd b;
  double c = 0.0, count = 0.0;
  void add(const Sums& other, double factor);
};
using GroupOf = std::function<int(size_t recording, size_t sample)>;  // -1: in none; recording: its place in the list
std::vector<Sums> sum_groups(const Linear& linear, int groups, const GroupOf& group_of);

// Sum of squares of stretches predicted from the others, with the parameters `columns` free, one Gauss-Newton step.
std::vector<Sums> sum_folds(const Linear& linear);
double cross_validate(const std::vector<Sums>& folds, const std::vector<long>& columns, const Eigen::VectorXd& width);

// The step of the parameters that samples with part(recording, sample) == `which` ask for, and its covariance from the
// scatter between stretches. False when there are too few samples.
struct PartStep {
  Eigen::VectorXd step, sigma;
};
bool calc_part_step(const Linear& linear, const GroupOf& part, int which, PartStep* out);

}  // namespace hrp::diagnosis
