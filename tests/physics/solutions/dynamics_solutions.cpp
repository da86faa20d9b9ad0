// SPDX-License-Identifier: BSD-3-Clause
#include "tests/physics/solutions/dynamics_solutions.h"

#include <cmath>

namespace hrp::solutions {
namespace {

using Phase = std::array<double, 4>;  // angle 1, angle 2 (relative), rates

// Lagrange's equations in absolute angles a = q1, b = q1 + q2 (every textbook), turned back to relative ones.
Phase calc_rates(const DoublePendulum& s, const Phase& x) {
  const double a = x[0], b = x[0] + x[1], wa = x[2], wb = x[2] + x[3];
  const double c = std::cos(a - b), sn = std::sin(a - b), m = s.mass1 + s.mass2;
  const double A = m * s.length1, B = s.mass2 * s.length2 * c, C = s.length1 * c, D = s.length2;
  const double e = -s.mass2 * s.length2 * sn * wb * wb - m * s.gravity * std::sin(a);
  const double f = s.length1 * sn * wa * wa - s.gravity * std::sin(b);
  const double det = A * D - B * C;
  const double aa = (e * D - B * f) / det, ab = (A * f - C * e) / det;
  return {x[2], x[3], aa, ab - aa};
}

Phase add(const Phase& x, const Phase& k, double h) {
  return {x[0] + h * k[0], x[1] + h * k[1], x[2] + h * k[2], x[3] + h * k[3]};
}

}  // namespace

Phase integrate_double_pendulum(const DoublePendulum& pendulum, Phase x, double time) {
  const int steps = static_cast<int>(std::ceil(time / 1e-4));
  const double h = time / steps;
  for (int i = 0; i < steps; ++i) {
    const Phase k1 = calc_rates(pendulum, x), k2 = calc_rates(pendulum, add(x, k1, h / 2));
    const Phase k3 = calc_rates(pendulum, add(x, k2, h / 2)), k4 = calc_rates(pendulum, add(x, k3, h));
    for (size_t j = 0; j < 4; ++j) x[j] += h / 6 * (k1[j] + 2 * k2[j] + 2 * k3[j] + k4[j]);
  }
  return x;
}

Eigen::Vector3d calc_symmetric_top_rate(double I1, double I3, const Eigen::Vector3d& w, double time) {
  const double rate = (I3 - I1) / I1 * w.z();  // precession of (w1, w2) about axis 3
  const double c = std::cos(rate * time), s = std::sin(rate * time);
  return {c * w.x() - s * w.y(), s * w.x() + c * w.y(), w.z()};
}

double calc_damped_oscillation(double mass, double damping, double stiffness, double x0, double time) {
  const double decay = damping / (2 * mass), w = std::sqrt(stiffness / mass - decay * decay);
  return x0 * std::exp(-decay * time) * (std::cos(w * time) + decay / w * std::sin(w * time));
}

}  // namespace hrp::solutions
