// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/report/fit_figures.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/floating/fit/remaining.h"

namespace hrp::diagnosis::floating {
namespace {

// Mismatch over noise, by part (train, validate): sums over rows of squares, noise included, before and after.
struct PartSum {
  double before = 0, after = 0, rows = 0;
  static double calc_rms(double sum, double rows) { return rows > 0 ? std::sqrt(sum / rows) : 0; }
};

struct Figures {
  PartSum part[2];
  // Over equations: log(1 + mismatch over noise) of both models, and by how much it could shrink by the columns at
  // hand.
  double before = 0, after = 0, could = 0;
};

void add_equation(const ReportState& state, size_t c, Figures* sum) {
  const LeggedFitter& fitter = state.fitter;
  const LeggedFit& nominal = state.outcome.nominal;
  for (int p = 0; p < 2; ++p) {
    const auto n = static_cast<double>(fitter.count(p ? Part::kHeld : Part::kTrain, c));
    sum->part[p].before += n * (1 + nominal.mean_square[p][c] / fitter.floor(c));
    sum->part[p].after += n * (1 + state.model.mean_square[p][c] / fitter.floor(c));
    sum->part[p].rows += n;
  }
  if (fitter.channels()[c].rows() == 0) return;
  const double x = get_mean_square(fitter, nominal, c) / fitter.floor(c);
  const double y = get_mean_square(fitter, state.model, c) / fitter.floor(c);
  sum->before += std::log1p(x);
  sum->after += std::log1p(y);
  sum->could += std::log1p(x) - std::log1p(x * (1 - std::max(fitter.calc_ceiling(c), x > 0 ? 1 - y / x : 0)));
}

void add_units(const UnitFit& units, Figures* sum) {
  for (int p = 0; p < 2; ++p) {
    sum->part[p].before += units.rows[p] * (1 + units.before[p] / units.exact);
    sum->part[p].after += units.rows[p] * (1 + units.after[p] / units.exact);
    sum->part[p].rows += units.rows[p];
  }
  const int judged = units.rows[1] > 0 ? 1 : 0;
  const double before = std::log1p(units.before[judged] / units.exact),
               after = std::log1p(units.after[judged] / units.exact);
  sum->before += before;
  sum->after += after;
  sum->could += before - after;
}

SignalFit make_signal_fit(const ReportState& state, size_t c) {
  const ChannelRows& rows = state.fitter.channels()[c];
  return {rows.info.signal + " (" + get_text(rows.info.equation) + ")", rows.info.unit,
          std::sqrt(get_mean_square(state.fitter, state.outcome.nominal, c)),
          std::sqrt(get_mean_square(state.fitter, state.model, c)), rows.scale};
}

}  // namespace

void add_fit_figures(const UnitFit& units, ReportState* state) {
  Figures sum;
  Evidence& out = state->evidence;
  for (size_t c = 0; c < state->fitter.channels().size(); ++c) {
    add_equation(*state, c, &sum);
    if (state->fitter.channels()[c].rows() > 0) out.fit.signals.push_back(make_signal_fit(*state, c));
  }
  if (!units.signal.empty()) {
    add_units(units, &sum);
    const int judged = units.rows[1] > 0 ? 1 : 0;
    out.fit.signals.push_back(
        {units.signal, "N", std::sqrt(units.before[judged]), std::sqrt(units.after[judged]), units.scale});
  }
  const PartSum &train = sum.part[0], &held = sum.part[1];
  out.fit.train_before = PartSum::calc_rms(train.before, train.rows);
  out.fit.train_after = PartSum::calc_rms(train.after, train.rows);
  out.fit.validate_before = PartSum::calc_rms(held.before, held.rows);
  out.fit.validate_after = PartSum::calc_rms(held.after, held.rows);
  out.explained = sum.before > 0 ? std::clamp((sum.before - sum.after) / sum.before, 0.0, 1.0) : 0;
  out.ceiling = sum.before > 0 ? std::clamp(sum.could / sum.before, 0.0, 1.0) : 0;
}

}  // namespace hrp::diagnosis::floating
