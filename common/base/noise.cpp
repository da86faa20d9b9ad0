// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/noise.h"

#include <cmath>

namespace hrp {
namespace {

// SplitMix64's finaliser (Steele, Lea, Flood 2014): a hash whose bits pass for random.
unsigned long long mix_bits(unsigned long long x) {
  x += 0x9E3779B97F4A7C15ull;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ull;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBull;
  return x ^ (x >> 31);
}

// Uniform in (0, 1).
double make_uniform(unsigned long long bits) { return (static_cast<double>(bits >> 11) + 0.5) * 0x1.0p-53; }

}  // namespace

double calc_noise(unsigned long long seed, unsigned long long channel, unsigned long long step) {
  const unsigned long long key = mix_bits(mix_bits(mix_bits(seed) ^ channel) ^ step);
  const double u = make_uniform(key), w = make_uniform(mix_bits(key));
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * M_PI * w);  // Box-Muller
}

}  // namespace hrp
