// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/checks/samples.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "diagnosis/data/gaps.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/data/range.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

// Share of samples that repeat the previous one while the joint moves.
double find_held_share(const std::vector<double>& signal, const std::vector<double>& position) {
  const double travel = calc_range(position);
  double held = 0.0, count = 0.0;
  for (size_t k = 1; k < signal.size(); ++k) {
    // Moving: at least a thousandth of the travel over four samples.
    if (k >= 4 && std::abs(position[k] - position[k - 4]) < 1e-3 * travel) continue;
    if (!std::isfinite(signal[k]) && !std::isfinite(signal[k - 1])) continue;
    held += signal[k] == signal[k - 1] || !std::isfinite(signal[k]) ? 1.0 : 0.0;
    count += 1.0;
  }
  return count > 50.0 ? held / count : 0.0;
}

Json list_held(const Experiment& e, const Recording& r, double rate) {
  Json list = Json::array();
  for (size_t j = 0; j < r.joints.size(); ++j) {
    const std::vector<double>& position = r.joints[j].signal[0];
    for (int q = 0; q < kQuantities && !position.empty(); ++q) {
      const std::vector<double>& signal = r.joints[j].signal[q];
      const double held = signal.empty() ? 0.0 : find_held_share(signal, position);
      // One that never changes is of a joint without a drive.
      if (held > kPart && held < 1.0 - kTrace)
        list.push_back({{"signal", e.signal_name(static_cast<int>(j), static_cast<Quantity>(q))},
                        {"rate", round_to((1.0 - held) * rate, 3)}});
    }
  }
  return list;
}

}  // namespace

Json make_sample_check(const Experiment& e, const Recording& r) {
  std::vector<double> steps;
  for (size_t k = 1; k < r.size(); ++k) steps.push_back(r.time[k] - r.time[k - 1]);
  const double period = find_quantile(steps, 0.5);
  Json gaps = Json::array();
  double lost = 0.0;
  for (size_t k = 1; k < r.size(); ++k) {
    if (r.time[k] - r.time[k - 1] <= kGapPeriods * period) continue;
    lost += r.time[k] - r.time[k - 1];
    if (gaps.size() < kMostInList) gaps.push_back({round_to(r.time[k - 1], 6), round_to(r.time[k], 6)});
  }
  const double rate = period > 0.0 ? 1.0 / period : 0.0;
  return {{"file", r.spec.name},
          {"role", r.spec.train ? "train" : "validate"},
          {"duration", round_to(r.duration(), 5)},
          {"samples", r.size()},
          {"rate", round_to(rate, 4)},
          {"jitter", round_to((find_quantile(steps, 0.95) - find_quantile(steps, 0.05)) / std::max(1e-12, period), 2)},
          {"lost", round_to(lost, 3)},
          {"gaps", gaps},
          {"held", list_held(e, r, rate)}};
}

}  // namespace hrp::diagnosis
