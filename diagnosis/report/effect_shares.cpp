// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/report/effect_shares.h"

#include <algorithm>

#include "diagnosis/estimate/shapley.h"

namespace hrp::diagnosis {
namespace {

// Squares above the noise, in units of the noise's.
double calc_above(double rms) { return rms * rms - 1.0; }

}  // namespace

std::vector<double> calc_effect_shares(const Hypothesis& model, double nominal,
                                       const std::function<double(const Hypothesis&)>& calc_left) {
  const double above = calc_above(nominal);
  if (above <= 0.0) return std::vector<double>(model.size(), 0.0);
  return calc_shapley(model.size(), [&](size_t mask) {
    Hypothesis part;
    for (size_t i = 0; i < model.size(); ++i) {
      if (mask >> i & 1) part.push_back(model[i]);
    }
    return std::clamp(1.0 - calc_above(calc_left(part)) / above, -1.0, 1.0);
  });
}

}  // namespace hrp::diagnosis
