// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/fit/remaining.h"

#include <algorithm>
#include <cmath>

#include "common/base/has.h"
#include "diagnosis/data/mean.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/report/words.h"

namespace hrp::diagnosis::floating {
namespace {

Remaining make_remaining(const ChannelRows& rows, double before, double after, bool varies) {
  Remaining r;
  const ChannelInfo& info = rows.info;
  r.where = {{info.place, info.name}};
  r.unit = info.unit;
  r.before = before;
  r.after = after;
  const bool hidden = varies && before <= 0;  // seen while other rows weighed more
  if (hidden) r.before = r.after = calc_rms(rows.y);
  r.statement = info.name + " (equation: " + get_text(info.equation) +
                "): " + format("%.3g of %.3g ", r.after, r.before) + info.unit + " are left, root mean square " +
                (hidden ? "with noise." : "beyond noise.");
  if (varies) r.statement += " An effect that explains part of it is not the same everywhere: no known cause is.";
  return r;
}

// What an equation predicts of a signal is worth nothing: it leaves nearly all that there is, and more than chance. Of
// few rows this is all that tells.
bool is_as_large_as_signal(const LeggedFitter& fitter, double mean_square, Part part, size_t channel) {
  const ChannelRows& rows = fitter.channels()[channel];
  const double size = rows.scale * rows.scale + rows.mean * rows.mean;
  const double chance = fitter.floor(channel) / std::sqrt(std::max(1.0, fitter.count_independent(part, channel)));
  return !is_of_soles(rows.info) && mean_square > kNearlyAll * kNearlyAll * size && mean_square > kUnlikely * chance;
}

}  // namespace

Part find_judged_part(const LeggedFitter& fitter, size_t channel) {
  return fitter.count(Part::kHeld, channel) > 0 ? Part::kHeld : Part::kTrain;
}

double get_mean_square(const LeggedFitter& fitter, const LeggedFit& fit, size_t channel) {
  return fit.mean_square[static_cast<size_t>(find_judged_part(fitter, channel))][channel];
}

bool is_of_soles(const ChannelInfo& info) {
  return info.equation.is(EquationKind::kTilt) || info.equation.is(EquationKind::kHeight);
}

bool is_left(const LeggedFitter& fitter, const LeggedFit& fit, size_t channel) {
  const Part part = find_judged_part(fitter, channel);
  const double left = get_mean_square(fitter, fit, channel);
  if (is_as_large_as_signal(fitter, left, part, channel)) return true;
  if (left <= kUnlikely * kUnlikely * fitter.floor(channel)) return false;
  const bool lasts =
      fitter.count_independent(part, channel) < kMinority * static_cast<double>(fitter.count(part, channel));
  return fitter.calc_ceiling(channel) > kMuch || (lasts && !is_of_soles(fitter.channels()[channel].info));
}

std::vector<Remaining> list_remaining(const LeggedFitter& fitter, const LeggedFit& nominal, const LeggedFit& model,
                                      const std::vector<size_t>& unsteady) {
  const auto get = [&](const LeggedFit& fit, size_t c) { return get_mean_square(fitter, fit, c); };
  const auto varies = [&](size_t c) { return has(unsteady, c); };
  // No model is more exact: less is nothing.
  const auto is_something = [&](size_t c) { return std::sqrt(get(model, c)) > fitter.find_exactness(c); };
  std::vector<size_t> order;
  for (size_t c = 0; c < fitter.channels().size(); ++c) {
    const bool stands_out =
        is_left(fitter, model, c) || (get(model, c) < kLargely * get(nominal, c) && is_something(c));
    if (fitter.channels()[c].rows() > 0 && (stands_out || varies(c))) order.push_back(c);
  }
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return get(nominal, a) / fitter.floor(a) > get(nominal, b) / fitter.floor(b);
  });
  if (order.size() > kShortList) order.resize(kShortList);
  std::vector<Remaining> out;
  for (size_t c : order) {
    out.push_back(
        make_remaining(fitter.channels()[c], std::sqrt(get(nominal, c)), std::sqrt(get(model, c)), varies(c)));
  }
  return out;
}

}  // namespace hrp::diagnosis::floating
