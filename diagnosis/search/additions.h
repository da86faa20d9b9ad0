// SPDX-License-Identifier: BSD-3-Clause
// Ranks effects that could be added to a hypothesis fitted through the simulation, by score tests (Rao 1948). A small
// step of every effect at every place is simulated. The gain is the part of the residual that the effect could remove
// while all fitted parameters follow. Other than signatures in the missing effort, this sees what remains after the
// fit, on the recordings as they are.
#pragma once

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis {

// A candidate effect with its gain.
struct Addition {
  Effect start;       // linearised parameters
  double gain = 0.0;  // decrease of chi2 in training and held-out recordings, with parameters from the training ones
};

// Best first. Effects that would make the held-out recordings worse are left out. The problem must have the start
// states and step errors of the hypothesis.
std::vector<Addition> rank_additions(const Problem& problem, const Hypothesis& fitted);

}  // namespace hrp::diagnosis
