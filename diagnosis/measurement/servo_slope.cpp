// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/servo_slope.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "diagnosis/estimate/gram.h"

namespace hrp::diagnosis {
namespace {

constexpr size_t kCells = 24;  // parts of a joint's travel, shorter than half a ripple's period

// A series minus its mean over each cell of the position's range; one cell for the overall mean.
std::vector<double> centre(std::vector<double> x, const std::vector<size_t>& cell) {
  std::vector<double> sum(kCells, 0.0), n(kCells, 0.0);
  for (size_t k = 0; k < x.size(); ++k) {
    sum[cell[k]] += x[k];
    n[cell[k]] += 1.0;
  }
  for (size_t k = 0; k < x.size(); ++k) x[k] -= sum[cell[k]] / n[cell[k]];
  return x;
}

std::vector<size_t> find_cells(const std::vector<double>& position) {
  const auto [low, high] = std::minmax_element(position.begin(), position.end());
  std::vector<size_t> cells;
  for (double q : position)
    cells.push_back(std::min(
        kCells - 1, static_cast<size_t>(static_cast<double>(kCells) * (q - *low) / std::max(1e-12, *high - *low))));
  return cells;
}

// Slope of effort over law with a law kLaterSamples samples away as the instrument. Encoder noise in the law is
// uncorrelated after that time, so it does not bias the slope. All series are centred in each cell. A log that comes
// late by d is nearer to an earlier law: with the law's autocorrelation R(t), the slope is R(t - d) / R(t), which is
// not 1. With a later law it is R(t + d) / R(t). The mean of both is free of the first order in d.
ServoSlope find_slope(const ServoPairs& pairs, const std::vector<size_t>& all_cells) {
  const size_t n = pairs.law.size() - 2 * kLaterSamples;
  const auto cut = [&](const std::vector<double>& x, size_t from) {
    return std::vector<double>(x.begin() + static_cast<long>(from), x.begin() + static_cast<long>(from + n));
  };
  const std::vector<size_t> cells(all_cells.begin() + kLaterSamples, all_cells.end() - kLaterSamples);
  const std::vector<double> law = centre(cut(pairs.law, kLaterSamples), cells),
                            effort = centre(cut(pairs.effort, kLaterSamples), cells);
  const std::vector<double> around[2] = {centre(cut(pairs.law, 0), cells),
                                         centre(cut(pairs.law, 2 * kLaterSamples), cells)};
  std::vector<double> top[2], bottom[2];
  double sums[2] = {0.0, 0.0}, slopes[2];
  for (size_t side = 0; side < 2; ++side) {
    top[side].assign(kFolds, 0.0);
    bottom[side].assign(kFolds, 0.0);
    for (size_t k = 0; k < n; ++k) {
      const size_t stretch = k * kFolds / n;
      top[side][stretch] += around[side][k] * effort[k];
      bottom[side][stretch] += around[side][k] * law[k];
    }
    sums[side] = std::accumulate(bottom[side].begin(), bottom[side].end(), 0.0);
    if (!(sums[side] > 0.0)) return {};
    slopes[side] = std::accumulate(top[side].begin(), top[side].end(), 0.0) / sums[side];
  }
  ServoSlope slope;
  slope.value = 0.5 * (slopes[0] + slopes[1]);
  double square = 0.0;
  for (size_t s = 0; s < kFolds; ++s) {
    double left = 0.0;
    for (size_t side = 0; side < 2; ++side) left += 0.5 * (top[side][s] - slope.value * bottom[side][s]) / sums[side];
    square += left * left;
  }
  // The second order in d is about the square of the first one.
  slope.std = std::hypot(std::sqrt(square * kFolds / (kFolds - 1)), std::pow(0.5 * (slopes[0] - slopes[1]), 2));
  return slope;
}

}  // namespace

ServoSlope find_slope(const ServoPairs& pairs) {
  const ServoSlope of_all = find_slope(pairs, std::vector<size_t>(pairs.law.size(), 0));
  const ServoSlope at_places = find_slope(pairs, find_cells(pairs.position));
  return at_places.std < of_all.std ? at_places : of_all;
}

double find_slope_beside_damping(const ServoPairs& pairs) {
  const std::vector<size_t> one(pairs.law.size(), 0);
  const std::vector<double> law = centre(pairs.law, one), damping = centre(pairs.damping, one),
                            effort = centre(pairs.effort, one);
  Eigen::Matrix2d of_columns = Eigen::Matrix2d::Zero();
  Eigen::Vector2d of_effort = Eigen::Vector2d::Zero();
  for (size_t k = kLaterSamples; k + kLaterSamples < law.size(); ++k) {
    const size_t before = k - kLaterSamples, after = k + kLaterSamples;
    const Eigen::Vector2d around(law[before] + law[after], damping[before] + damping[after]);
    of_columns += around * Eigen::RowVector2d(law[k], damping[k]);
    of_effort += around * effort[k];
  }
  const Eigen::FullPivLU<Eigen::Matrix2d> lu(of_columns);
  return lu.isInvertible() ? lu.solve(of_effort)[0] : find_slope(pairs).value;
}

}  // namespace hrp::diagnosis
