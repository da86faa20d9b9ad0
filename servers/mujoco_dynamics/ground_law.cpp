// SPDX-License-Identifier: BSD-3-Clause
#include "servers/mujoco_dynamics/ground_law.h"

#include <algorithm>
#include <cmath>

namespace hrp {
namespace {

// Half: the point carries no more than the link's own mass along. Smaller ones make MuJoCo's step explicit.
constexpr double kLeastImpedance = 0.5;
// (omega dt)^2 of a point alone. A sole has four of them, and MuJoCo's step is explicit in the spring.
constexpr double kStiffest = 0.1;

}  // namespace

GroundLaw calc_ground_law(const ContactSpec& contact, double load, double mass, double time_step) {
  const double K = contact.stiffness / contact.shared_points, n = contact.exponent;
  const double depth = std::pow(load / K, 1.0 / n);
  const double stiffness = n * K * std::pow(depth, n - 1.0);  // [N/m]
  const double damping = 1.5 * contact.alpha * load;          // [N s/m] lambda delta^n, lambda = 3/2 alpha K
  const double rate = stiffness / mass;                       // [1/s^2]
  GroundLaw law;
  law.impedance = std::max(kLeastImpedance, rate / (rate + kStiffest / (time_step * time_step)));
  const double R = (1.0 - law.impedance) / law.impedance / mass;
  law.k = stiffness * R;
  law.b = damping * R;
  return law;
}

}  // namespace hrp
