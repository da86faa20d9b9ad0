// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/fitted_part.h"

#include "diagnosis/data/stretches.h"
#include "diagnosis/search/subtrees.h"

namespace hrp::diagnosis {
namespace {

// Joints times seconds: some hundred simulations of each joint take minutes of two cores.
constexpr double kFitted = 600.0;

}  // namespace

FittedPart::FittedPart(const Problem& problem, const Problem& whole) : given_(problem), given_whole_(whole) {
  if (calc_joint_seconds(*problem.experiment) <= kFitted) return;
  std::vector<int> recordings = problem.train;
  recordings.insert(recordings.end(), problem.validate.begin(), problem.validate.end());
  experiment_ = make_screened(*problem.experiment, kFitted, recordings);
  part_ = make_problem(*experiment_, problem.jobs);
  part_.options = problem.options;
  part_.most_work = problem.most_work;
  whole_part_ = part_;
  split_subtrees(&whole_part_);
}

double FittedPart::seconds() const {
  return calc_joint_seconds(*problem().experiment) / problem().experiment->num_joints();
}

}  // namespace hrp::diagnosis
