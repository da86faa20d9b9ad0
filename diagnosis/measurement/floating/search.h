// SPDX-License-Identifier: BSD-3-Clause
// Which effects the equations of a robot on its feet ask for: one hypothesis over all phases and recordings.
#pragma once

#include <functional>

#include "diagnosis/measurement/floating/least_squares.h"

namespace hrp::diagnosis::floating {

// Another effect that explains as much in the place of one that was found.
struct Rival {
  Candidate effect;
  Eigen::VectorXd x, std;
  double behind = 0;  // of the gain
};

struct FoundEffect {
  Candidate effect;
  Eigen::VectorXd x, std, scatter;  // std: with what recordings differ by and equations are exact to; scatter: by chance
  double gain = 0;             // n log of what is left without it over what is left with it, held-out
  double share = 0;            // of its place's held-out mismatch, 0 to 1
  double spread = 0;           // of the parts' values over the value
  size_t channel = 0;          // the equation that tells it most
  std::vector<Rival> rivals;
  bool sums_up = false;        // a zero that only the sum of all feet's forces tells: any other foot may have it
};

struct LeggedOutcome {
  LeggedFit nominal, chosen;
  std::vector<FoundEffect> effects;
  std::vector<size_t> unsteady;  // equations that effects helped that were not of one size: something is there
};

using Say = std::function<void(const std::string&)>;
LeggedOutcome search_legged(LeggedFitter* fitter, const std::vector<Candidate>& candidates, const ColumnLayout& layout,
                            double reach, const Say& say);

}  // namespace hrp::diagnosis::floating
