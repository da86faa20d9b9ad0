// SPDX-License-Identifier: BSD-3-Clause
#include "common/multibody/sine_cosine.h"

#include <cmath>
#include <cstdint>
#include <cstring>

namespace hrp {
namespace {

inline std::uint64_t to_bits(double x) {
  std::uint64_t bits;
  std::memcpy(&bits, &x, sizeof(bits));
  return bits;
}

inline double to_double(std::uint64_t bits) {
  double x;
  std::memcpy(&x, &bits, sizeof(x));
  return x;
}

// Minimax polynomials and the split of pi / 2 into exact parts of 33 bits: fdlibm (Sun Microsystems, 1993), k_sin.c,
// k_cos.c and e_rem_pio2.c. |r| <= pi / 4, z = r^2.
inline double calc_sine_polynomial(double r, double z) {
  const double p =
      8.33333333332248946124e-03 +
      z * (-1.98412698298579493134e-04 +
           z * (2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)));
  return r + r * z * (-1.66666666666666324348e-01 + z * p);
}

inline double calc_cosine_polynomial(double z) {
  const double p =
      4.16666666666666019037e-02 +
      z * (-1.38888888888741095749e-03 +
           z * (2.48015872894767294178e-05 + z * (-2.75573143513906633035e-07 +
                                                  z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11))));
  return 1.0 - (0.5 * z - z * z * p);
}

}  // namespace

void calc_sine_cosine(const double* __restrict angle, int n, double* __restrict sine, double* __restrict cosine) {
  constexpr double kRound = 6755399441055744.0;  // 1.5 * 2^52: adding it leaves the nearest integer in the last bits
  for (int i = 0; i < n; ++i) {
    const double shifted = angle[i] * 6.36619772367581382433e-01 + kRound;  // 2 / pi
    const std::uint64_t quarter = to_bits(shifted);
    const double k = shifted - kRound;
    const double r =
        ((angle[i] - k * 1.57079632673412561417e+00) - k * 6.07710050630396597660e-11) - k * 2.02226624879595063154e-21;
    const double z = r * r;
    const std::uint64_t s = to_bits(calc_sine_polynomial(r, z)), c = to_bits(calc_cosine_polynomial(z));
    const std::uint64_t odd = 0 - (quarter & 1);
    sine[i] = to_double(((s & ~odd) | (c & odd)) ^ ((quarter & 2) << 62));
    cosine[i] = to_double(((c & ~odd) | (s & odd)) ^ (((quarter + 1) & 2) << 62));
  }
  for (int i = 0; i < n; ++i) {
    if (std::abs(angle[i]) < 1e5) continue;  // beyond, k * (first part of pi / 2) is no longer exact; NaN ends here too
    sine[i] = std::sin(angle[i]);
    cosine[i] = std::cos(angle[i]);
  }
}

}  // namespace hrp
