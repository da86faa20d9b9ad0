// SPDX-License-Identifier: BSD-3-Clause
// Which effect to add to a hypothesis that was fitted through the simulation: a small step of every effect at every
// place is simulated, and what it could take away of the residual, everything fitted before following it, is the
// score test's gain (Rao 1948). Unlike the signatures in the missing effort it sees what is left after the fit, on
// recordings as they are, and knows what the fit has taken up already.
#pragma once

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis {

struct Addition {
  Effect start;       // the linear solution
  double gain = 0.0;  // of chi2, training recordings and those held out, by parameters learnt on the former
};

// Best first; those that would make the held-out recordings worse are left out. The problem's starts and step errors
// are those of the hypothesis.
std::vector<Addition> rank_additions(const Problem& problem, const Hypothesis& fitted);

}  // namespace hrp::diagnosis
