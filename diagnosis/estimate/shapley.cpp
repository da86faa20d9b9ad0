// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/estimate/shapley.h"

namespace hrp::diagnosis {
namespace {

std::vector<double> calc_last_steps(size_t players, const std::function<double(size_t mask)>& value) {
  const size_t all = (size_t{1} << players) - 1;
  const double whole = value(all);
  std::vector<double> out(players, 0.0);
  for (size_t p = 0; p < players; ++p) out[p] = whole - value(all & ~(size_t{1} << p));
  return out;
}

}  // namespace

std::vector<double> calc_shapley(size_t players, const std::function<double(size_t mask)>& value, size_t most) {
  if (players > most) return calc_last_steps(players, value);
  std::vector<double> of(size_t{1} << players), out(players, 0.0), factorial(players + 1, 1.0);
  for (size_t k = 1; k <= players; ++k) factorial[k] = factorial[k - 1] * static_cast<double>(k);
  for (size_t mask = 0; mask < of.size(); ++mask) of[mask] = value(mask);
  for (size_t p = 0; p < players; ++p) {
    for (size_t mask = 0; mask < of.size(); ++mask) {
      if (mask >> p & 1) continue;
      const auto before = static_cast<size_t>(__builtin_popcountll(mask));
      out[p] += factorial[before] * factorial[players - before - 1] / factorial[players] *
                (of[mask | size_t{1} << p] - of[mask]);
    }
  }
  return out;
}

}  // namespace hrp::diagnosis
