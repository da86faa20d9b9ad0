// SPDX-License-Identifier: BSD-3-Clause
// How often an iteration is repeated, and how many of a ranking go on. None is tuned alone: a result that depends on
// one of these numbers has not converged, or its ranking does not tell.
#pragma once

#include <cstddef>

namespace hrp::diagnosis {

// Of a correction that is nearly linear: each round leaves a tenth of the last one's error, or less.
constexpr int kFewRounds = 3;
// Of Gauss and Newton, which double their digits once they are near.
constexpr int kRounds = 12;
// Of an iteration that converges linearly and ends by itself when it has settled.
constexpr int kMostRounds = 60;
// Of a bracket or a step: to a four thousandth of it.
constexpr int kHalvings = 12;

// The best of a ranking, of which each costs a fit or a simulation of its own.
constexpr size_t kLookedAt = 3;
// The best of a ranking that stay in the race, where one costs little.
constexpr size_t kShortList = 10;

}  // namespace hrp::diagnosis
