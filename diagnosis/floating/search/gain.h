// SPDX-License-Identifier: BSD-3-Clause
// How much a step of the search wins, what it costs, and whether chance explains it. Gains are in n log: the number of
// independent rows times the logarithm of the ratio of the mean squares that are left.
#pragma once

#include "diagnosis/floating/search/state.h"

namespace hrp::diagnosis::floating {

// What an effect must gain on held-out rows [n log].
constexpr double kLeastHeldGain = 4;
// Two gains that differ by less do not decide between two effects [n log]. Of large gains the same holds within
// kDetail: what no law holds makes a difference in proportion to it.
constexpr double kTie = 8;

// What an effect must win on all rows to be accepted; more for each further coefficient.
double calc_cost(const Candidate& candidate);

// On fitted and held-out rows together.
double calc_total_gain(const SearchState& state, const LeggedFit& without, const LeggedFit& with);

// What a chosen effect wins on held-out rows of the equations that it changes. In the others, effects beside it change:
// a zero of an IMU that differs from recording to recording wins or loses there by what it is taken for in these.
double calc_own_held_gain(const SearchState& state, const LeggedFit& without, size_t effect);

// The equation that gains most.
size_t find_main_channel(const SearchState& state, const LeggedFit& without, const LeggedFit& with);
// The same by the errors after the step. Before it, a constant error of another equation counts as one.
size_t find_lasting_channel(const SearchState& state, const LeggedFit& with);

// Share of an equation's nominal held-out mismatch that goes from `without` to `with`.
double calc_share(const SearchState& state, const LeggedFit& without, const LeggedFit& with, size_t channel);

// Whether an effect takes away more than a detail of an equation's held-out mismatch, or half of what all others leave.
// A load and a scale of its sensors explain each other to nine tenths, and both are needed. A late clock makes little
// beside a load. Columns are of first order: what the others leave of the largest mismatch in these units may be blur,
// and half of that proves nothing.
bool matters(const SearchState& state, const LeggedFit& without, const LeggedFit& with, size_t channel);

// Whether the last effect of `with` takes away enough in comparison with the spread of the equation's signal
// (CandidateLaw::worth).
bool is_large_enough(const SearchState& state, const LeggedFit& without, const LeggedFit& with, size_t channel);

// Whether an effect's values are possible. Of several core coefficients, such as the gives of a sole about two axes,
// noise may make one that a motion does not tell negative: it counts as none.
bool is_possible(const SearchState& state, const LeggedFit& fit, size_t effect);

// Whether an effect is larger than its least size and than chance would make it, in all rows together. The limit is
// low: the gain on held-out rows is the strict test.
bool is_significant(const SearchState& state, const LeggedFit& fit, size_t effect);

}  // namespace hrp::diagnosis::floating
