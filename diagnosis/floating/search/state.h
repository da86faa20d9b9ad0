// SPDX-License-Identifier: BSD-3-Clause
// What the search has chosen so far, and fits of sets of effects.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/floating/search/search.h"

namespace hrp::diagnosis::floating {

struct SearchState {
  LeggedFitter& fitter;
  const std::vector<Candidate>& candidates;
  const ColumnLayout& layout;
  const Say& say;
  const Eigen::VectorXd* about;  // search_legged()
  LeggedFit nominal;             // without effects
  LeggedFit chosen;
  std::vector<Candidate> banned;  // were chosen and did not hold; they are not tried again
  std::vector<size_t> unsteady;   // equations that banned effects helped
};

// The same law at the same place.
bool is_same(const Candidate& a, const Candidate& b);
bool is_banned(const SearchState& state, const Candidate& candidate);

// Fits effects. A few rounds also find the inertia of loads and masses that lie elsewhere: it depends on their place,
// and the place is a result of the fit.
LeggedFit fit_effects(const SearchState& state, std::vector<Candidate> effects);
// What was chosen without one effect.
LeggedFit fit_without(const SearchState& state, size_t effect);

// Chooses these effects and iterates the weights of the rows: weights depend on what a fit leaves, and the fit depends
// on the weights. Bans effects that have no information with the new weights.
void settle(const std::vector<Candidate>& effects, SearchState* state);

// To whoever follows the search, such as "not sure: joint_offset at {"joint":"l_ankle"}" with `what` "not sure:".
void say_of(const SearchState& state, const std::string& what, const Candidate& candidate);

}  // namespace hrp::diagnosis::floating
