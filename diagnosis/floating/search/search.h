// SPDX-License-Identifier: BSD-3-Clause
// Which effects explain the equations of a legged robot: one hypothesis over all phases and recordings.
//
//   state         what the search has chosen so far; fits of sets of effects
//   gain          how much a step wins, what it costs, and whether chance explains it
//   trials        every candidate beside a set of effects
//   growth        adds, prunes, exchanges and merges effects until nothing wins any more
//   doubts        takes out effects that the growth chose and that a report must not claim
//   deviations    how exactly the values of an effect are known
//   description   what a report says of each effect that is left
//   rivals        other effects that explain as much
#pragma once

#include <functional>

#include "diagnosis/floating/fit/least_squares.h"

namespace hrp::diagnosis::floating {

// Another effect that explains about as much in the place of one that was found.
struct Rival {
  Candidate effect;
  Eigen::VectorXd x, std;
};

struct FoundEffect {
  Candidate effect;
  Eigen::VectorXd x;
  Eigen::VectorXd std;      // of x: chance, differences between recordings, and what the equations are exact to
  Eigen::VectorXd scatter;  // of x: chance and differences between recordings alone
  double gain = 0;          // n log of what is left without the effect over what is left with it, all rows
  double share = 0;         // of its equation's held-out mismatch that the effect takes away, 0 to 1
  double spread = 0;        // of the first value over the recordings, relative to the value
  size_t channel = 0;       // the equation that shows it most
  std::vector<Rival> rivals;
  bool sums_up = false;  // a sensor's zero that only the sum of all feet's forces shows: any other foot may have it
};

struct LeggedOutcome {
  LeggedFit nominal, chosen;
  std::vector<FoundEffect> effects;  // in the order of chosen.effects
  std::vector<size_t> unsteady;      // equations that dropped effects helped: they lack something that has no name yet
};

// Takes a sentence on the progress of the search. It may be empty.
using Say = std::function<void(const std::string&)>;

// `about`: the values of sensors' and drives' faults, by column, that the equations were made about. A delay or a turn
// that is far from its value there is not judged by what it leaves, because its columns are of first order. Null: every
// effect is judged.
LeggedOutcome search_legged(LeggedFitter* fitter, const std::vector<Candidate>& candidates, const ColumnLayout& layout,
                            const Say& say, const Eigen::VectorXd* about = nullptr);

}  // namespace hrp::diagnosis::floating
