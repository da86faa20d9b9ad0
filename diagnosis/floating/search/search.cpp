// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/search/search.h"

#include <utility>

#include "diagnosis/floating/search/description.h"
#include "diagnosis/floating/search/doubts.h"
#include "diagnosis/floating/search/growth.h"

namespace hrp::diagnosis::floating {
namespace {

// Grows a hypothesis from nothing, and repeats it without each effect that does not hold.
std::vector<FoundEffect> find_effects(SearchState* state) {
  state->nominal = state->fitter.fit({});
  state->chosen = state->nominal;
  do {
    grow_listed(state);
  } while (drop_unsteady(state));
  while (true) {
    grow_free(state);
    std::vector<FoundEffect> found = describe_effects(*state);
    if (!drop_doubtful(found, state)) return found;
  }
}

}  // namespace

LeggedOutcome search_legged(LeggedFitter* fitter, const std::vector<Candidate>& candidates, const ColumnLayout& layout,
                            const Say& say, const Eigen::VectorXd* about) {
  SearchState state{*fitter, candidates, layout, say, about, {}, {}, {}, {}};
  std::vector<FoundEffect> effects = find_effects(&state);
  // Rows at impacts normally weigh little. An effect that needs large accelerations, such as the rotor of a knee, may
  // show in those rows alone.
  if (effects.empty()) {
    fitter->count_impacts(true);
    settle({}, &state);
    effects = find_effects(&state);
  }
  if (effects.empty()) {
    fitter->count_impacts(false);
    settle({}, &state);
  }
  measure_by_all(state, &effects);
  return {std::move(state.nominal), std::move(state.chosen), std::move(effects), std::move(state.unsteady)};
}

}  // namespace hrp::diagnosis::floating
