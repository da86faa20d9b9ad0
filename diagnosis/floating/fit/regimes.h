// SPDX-License-Identifier: BSD-3-Clause
// Whether an effect has one size in every regime that tells it: in each phase of walking, in calm and in rough rows,
// and, of a sole, wherever it presses. An effect that only stands in for another cause has not.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/floating/fit/least_squares.h"

namespace hrp::diagnosis::floating {

// The rows of a phase of the gait; the calm and the rough half; those in which a sole that bears much is pressed in its
// middle; those in which a foot bears little, and much.
enum class RegimeKind { kPhase, kCalm, kRough, kMiddle, kLittle, kMuch };

struct Regime {
  RegimeKind kind = RegimeKind::kPhase;
  std::string name;    // "phase 1", "calm", "pressed in the middle"
  double size = 1;     // of the effect there, 1: as in the whole
  double std = 1e9;    // of size, by blocks
  double least = 0.5;  // that the size must be
};

// Regimes of an effect of a fit. Sizes do not depend on each other's rows except through the fit.
std::vector<Regime> list_regimes(const LeggedFitter& fitter, const LeggedFit& fit, size_t effect,
                                 const ColumnLayout& layout);

// Whether no regime has less than its least size or more than twice the size, as far as a regime tells the size to a
// fifth and by more than three deviations.
bool is_steady(const std::vector<Regime>& regimes);

// By how much of its size, at most, a phase differs from the whole: as far as it tells the size to a fifth, and by more
// than three deviations. 0: none does.
double find_phase_spread(const std::vector<Regime>& regimes);

// Whether calm and rough rows tell the same size, to a factor of two or beyond chance.
bool is_alike(const std::vector<Regime>& regimes);

}  // namespace hrp::diagnosis::floating
