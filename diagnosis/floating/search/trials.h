// SPDX-License-Identifier: BSD-3-Clause
// Every candidate beside a set of effects: what each one would win.
#pragma once

#include <functional>

#include "diagnosis/floating/search/state.h"

namespace hrp::diagnosis::floating {

// A set of effects and one candidate more, which is the last effect of the fit.
struct LeggedTrial {
  LeggedFit fit;
  double gain = 0;     // [n log] on fitted rows, less the candidate's cost
  double held = 0;     // [n log] on held-out rows
  size_t channel = 0;  // the equation that gains most
  const Candidate& added() const { return fit.effects.back(); }
  size_t at() const { return fit.effects.size() - 1; }  // of the candidate among the effects
};

// Effects of the table, or free laws of physics that the table does not hold.
enum class Pool { kListed, kFree };

// Whether a candidate wins on fitted rows and on held-out rows, and pays its cost.
bool is_confirmed(const LeggedTrial& trial);

// Candidates beside the effects of `base`, without those whose values are impossible. Best first.
std::vector<LeggedTrial> list_trials(const SearchState& state, const LeggedFit& base, Pool pool,
                                     const std::function<bool(const LeggedTrial&)>& is_kept);
std::vector<LeggedTrial> list_confirmed(const SearchState& state, const LeggedFit& base, Pool pool);

// Listed candidates beside what was chosen that take half of an equation's mismatch (kHalf), by the gain that counts
// the errors after the step (LeggedFitter::calc_gain_after). An error that is constant, as a missing weight is, counts
// as few independent errors before the step, so that its gain is small.
std::vector<LeggedTrial> list_lasting(const SearchState& state);

}  // namespace hrp::diagnosis::floating
