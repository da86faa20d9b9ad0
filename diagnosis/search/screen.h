// SPDX-License-Identifier: BSD-3-Clause
// Ranks every effect at every place at once, without simulating: the effort that the recorded motion takes on paper
// against the effort that was logged (equation error), and the logged effort against what the servo should have asked
// for. Each effect has a signature there, linear in its parameters or one of a grid of shapes.
#pragma once

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis {

struct Candidate {
  Effect start;       // with start values of its parameters
  double gain = 0.0;  // decrease of the whitened sum of squares when it alone is added
  std::vector<int> columns;
};

struct Screening {
  std::vector<Candidate> candidates;  // by falling gain; one per effect and place
  double chi2 = 0.0;                  // of the nominal model
  double count = 0.0;
  std::vector<double> joint_chi2;  // per joint, of the missing effort, over its number of samples
};

// What is left after `base` has been taken into account; efforts of the effects in `base` are removed first.
Screening screen(const Problem& problem, const Hypothesis& base, const Paths* paths = nullptr);

}  // namespace hrp::diagnosis
