// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace hrp::cases {

// SplitMix64 (Steele, Lea, Flood 2014). Own generator, because the distributions of <random> differ between libraries
// and a seed must name the same case everywhere.
class Prng {
 public:
  explicit Prng(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }

  double uniform(double low, double high) { return low + (high - low) * (next() >> 11) * 0x1.0p-53; }
  double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  bool chance(double probability) { return uniform(0, 1) < probability; }
  double sign() { return chance(0.5) ? 1.0 : -1.0; }
  int below(int count) { return static_cast<int>(next() % static_cast<std::uint64_t>(count)); }

  // Polar method; the spare value is dropped so that one call is one draw whatever came before.
  double normal() {
    for (;;) {
      const double a = uniform(-1, 1), b = uniform(-1, 1), s = a * a + b * b;
      if (s > 0 && s < 1) return a * std::sqrt(-2 * std::log(s) / s);
    }
  }

  template <typename T>
  const T& pick(const std::vector<T>& from) {
    return from[static_cast<std::size_t>(below(static_cast<int>(from.size())))];
  }

  template <typename T>
  void shuffle(std::vector<T>& items) {
    for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[next() % i]);
  }

  // A stream of its own for a sub-task, so that drawing more in one place shifts nothing elsewhere.
  Prng fork(std::uint64_t salt) { return Prng(next() ^ (salt * 0xd1342543de82ef95ULL)); }

 private:
  std::uint64_t state_;
};

}  // namespace hrp::cases
