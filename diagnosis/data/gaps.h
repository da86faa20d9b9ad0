// SPDX-License-Identifier: BSD-3-Clause
// Gaps of a clock: steps between samples that are far longer than its period.
#pragma once

#include <algorithm>
#include <vector>

#include "diagnosis/data/quantile.h"

namespace hrp::diagnosis {

constexpr double kGapPeriods = 5.0;  // longest normal step, in periods
// Steps of a single sensor that are longer, in periods, lack a reading; jitter stays below.
constexpr double kLostPeriods = 3.5;
constexpr double kGapTime = 0.1;       // [s] shortest gap that cuts a recording or a bag
constexpr double kShortestPart = 1.0;  // [s] shortest part between gaps that is used

// Median step of stamps [s], without repeated ones; 0 for fewer than two.
inline double find_period(const std::vector<double>& time) {
  std::vector<double> steps;
  for (size_t k = 1; k < time.size(); ++k) {
    if (time[k] > time[k - 1]) steps.push_back(time[k] - time[k - 1]);
  }
  return find_median(std::move(steps));
}

// Longest step [s] across which a recording with this period [s] is not cut.
inline double find_cutting_gap(double period) { return std::max(kGapTime, kGapPeriods * period); }

}  // namespace hrp::diagnosis
