// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/report/unexplained.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/fit/remaining.h"
#include "diagnosis/floating/report/words.h"

namespace hrp::diagnosis::floating {
namespace {

// Of a force that is known to less than the robot's weight, an axis shows nothing.
void forget_unseen(double weight, std::vector<Estimate>* values) {
  for (Estimate& e : *values) {
    for (size_t i = 0; i < e.value.size() && e.unit == "N" && e.value.size() == 3; ++i) {
      if (!(kNinetyFive * e.std[i] < weight)) e.value[i] = e.std[i] = 0;
    }
  }
}

Remaining make_free_law(const ReportState& state, const FoundEffect& f) {
  Remaining r;
  const ChannelInfo& info = state.fitter.channels()[f.channel].info;
  std::vector<Estimate> values = make_estimates(f.effect, f.x, f.std);
  forget_unseen(state.log.mass * state.log.experiment->scenario.gravity_W.norm(), &values);
  r.where = f.effect.where;
  r.unit = info.unit;
  r.before = r.after = std::sqrt(get_mean_square(state.fitter, state.model, f.channel));
  r.statement = get_place(r.where) + ": " + f.effect.law->unlisted + " (" + describe(values) + "). It takes " +
                format("%.0f %% of the held-out mismatch of the equation '", 100 * f.share) + get_text(info.equation) +
                "' away. No scenario can hold it.";
  return r;
}

}  // namespace

std::vector<size_t> list_unsteady(const ReportState& state) {
  const LeggedOutcome& found = state.outcome;
  std::vector<size_t> out;
  std::copy_if(found.unsteady.begin(), found.unsteady.end(), std::back_inserter(out), [&](size_t c) {
    const double before = get_mean_square(state.fitter, found.nominal, c),
                 after = get_mean_square(state.fitter, found.chosen, c);
    const bool gone = has_free_law(found) && after < kNearlyAll * kNearlyAll * before;
    return !gone && !is_of_soles(state.fitter.channels()[c].info);
  });
  return out;
}

void add_unexplained(ReportState* state) {
  std::vector<Remaining>& out = state->evidence.remaining;
  for (const FoundEffect& f : state->outcome.effects) {
    if (!f.effect.is_listed()) out.push_back(make_free_law(*state, f));
  }
  std::vector<size_t> unsteady;
  if (state->evidence.findings.empty()) unsteady = list_unsteady(*state);
  const LeggedFit& model = has_free_law(state->outcome) ? state->outcome.chosen : state->model;
  for (Remaining& r : list_remaining(state->fitter, state->outcome.nominal, model, unsteady))
    out.push_back(std::move(r));
}

}  // namespace hrp::diagnosis::floating
