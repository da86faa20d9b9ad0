// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/report/report_state.h"

#include <algorithm>

#include "diagnosis/floating/fit/remaining.h"

namespace hrp::diagnosis::floating {

bool has_free_law(const LeggedOutcome& outcome) {
  return std::any_of(outcome.effects.begin(), outcome.effects.end(),
                     [](const FoundEffect& f) { return !f.effect.is_listed(); });
}

bool is_anything_left(const ReportState& state) {
  for (size_t c = 0; c < state.fitter.channels().size(); ++c) {
    if (state.fitter.channels()[c].rows() > 0 && is_left(state.fitter, state.model, c)) return true;
  }
  return false;
}

}  // namespace hrp::diagnosis::floating
