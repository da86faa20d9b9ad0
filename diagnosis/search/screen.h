// SPDX-License-Identifier: BSD-3-Clause
// Ranks all effects at all places without simulation, by their signatures in the equation error (missing.h): logged
// effort minus effort of the motion, and minus effort by the servo law. Signatures are linear in the parameters, with
// shapes from a grid.
#pragma once

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis {

// The best shape of an effect at a place.
struct Candidate {
  Effect start;       // with start values of its parameters
  double gain = 0.0;  // decrease of the whitened sum of squares if only this effect is added
  std::vector<int> columns;
};

// All candidates, and the mismatch that they could explain.
struct Screening {
  std::vector<Candidate> candidates;  // by decreasing gain; one per effect and place
  double chi2 = 0.0;                  // of the nominal model
  double count = 0.0;
  std::vector<double> joint_chi2;  // by joint: of the missing effort, per sample
};

// Screens the residual under `base`, along `paths` (null: as recorded).
Screening screen(const Problem& problem, const Hypothesis& base, const Paths* paths = nullptr);

}  // namespace hrp::diagnosis
