// SPDX-License-Identifier: BSD-3-Clause
#include "controller/walking/lipm.h"

#include <cmath>

namespace hrp::walking {

double Pendulum::calc_time_constant() const { return std::sqrt(zc / g); }

// [H03 eq. 8, 9] solved.
PendulumState calc_state(const Pendulum& pendulum, const PendulumState& start, const ZmpSegment& segment, double t) {
  const double Tc = pendulum.calc_time_constant();
  const double C = std::cosh(t / Tc), S = std::sinh(t / Tc);
  const Vector2d rate = segment.T > 0.0 ? Vector2d((segment.p1 - segment.p0) / segment.T) : Vector2d(Vector2d::Zero());
  const Vector2d p0 = segment.T > 0.0 ? segment.p0 : segment.p1;
  const Vector2d dx = start.x - p0, dv = start.v - rate;
  return {p0 + rate * t + C * dx + Tc * S * dv, rate + S / Tc * dx + C * dv};
}

// Over the foot x is odd in time (forward) or even (sideways) about the middle of the single support; about the middle
// of the double support, x minus half the step is odd: x = p + D sinh. Matching both at the seam gives the amplitude.
PendulumState calc_walk_primitive(const Pendulum& pendulum, const Vector2d& step, double Ts, double Td) {
  const double Tc = pendulum.calc_time_constant();
  const double C = std::cosh(0.5 * Ts / Tc), S = std::sinh(0.5 * Ts / Tc);
  PendulumState end;
  for (int axis = 0; axis < 2; ++axis) {
    const double even = axis == 0 ? S : C, odd = axis == 0 ? C : S;  // of position and velocity at the seam
    double amplitude = 0.5 * step[axis] / even;
    if (Td > 0.0) {
      const double half = 0.5 * Td / Tc;
      amplitude = Tc * step[axis] / Td / (odd + even * std::cosh(half) / std::sinh(half));
    }
    end.x[axis] = amplitude * even;
    end.v[axis] = amplitude * odd / Tc;
  }
  return end;
}

Vector2d calc_placement(const Pendulum& pendulum, const PendulumState& end, const Vector2d& foot,
                        const PendulumState& target, double Ts, double Td, const PlacementWeights& weights) {
  // The final state is linear in the placement: find it for two placements a metre apart.
  const auto find_final = [&](const Vector2d& p) {
    const PendulumState touch = calc_state(pendulum, end, {Td, foot, p}, Td);
    return calc_state(pendulum, touch, {Ts, p, p}, Ts);
  };
  const PendulumState at0 = find_final(foot), at1 = find_final(foot + Vector2d::Ones());
  Vector2d placement;
  for (int i = 0; i < 2; ++i) {
    const double gain_x = at1.x[i] - at0.x[i], gain_v = at1.v[i] - at0.v[i];
    const double D = weights.position * gain_x * gain_x + weights.velocity * gain_v * gain_v;
    placement[i] = foot[i] + (weights.position * gain_x * (target.x[i] - at0.x[i]) +
                              weights.velocity * gain_v * (target.v[i] - at0.v[i])) /
                                 D;
  }
  return placement;
}

Vector2d calc_divergent(const Pendulum& pendulum, const PendulumState& state) {
  return state.x + pendulum.calc_time_constant() * state.v;
}

std::vector<ZmpSegment> calc_transfer(const Pendulum& pendulum, const PendulumState& start, const Vector2d& p_start,
                                      const Vector2d& divergent, const Vector2d& p_end, double T) {
  const auto make = [&](const Vector2d& w1, const Vector2d& w2) {
    return std::vector<ZmpSegment>{{T / 3.0, p_start, w1}, {T / 3.0, w1, w2}, {T / 3.0, w2, p_end}};
  };
  const auto find_final = [&](const Vector2d& w1, const Vector2d& w2) {
    PendulumState state = start;
    for (const ZmpSegment& segment : make(w1, w2)) state = calc_state(pendulum, state, segment, segment.T);
    return calc_divergent(pendulum, state);
  };
  // Linear in the excursions; the smallest that does it lies along the gains.
  const Vector2d base = find_final(p_start, p_start), one = Vector2d::Ones();
  const Vector2d gain1 = find_final(p_start + one, p_start) - base, gain2 = find_final(p_start, p_start + one) - base;
  Vector2d w1 = p_start, w2 = p_start;
  for (int i = 0; i < 2; ++i) {
    const double share = (divergent[i] - base[i]) / (gain1[i] * gain1[i] + gain2[i] * gain2[i]);
    w1[i] += gain1[i] * share;
    w2[i] += gain2[i] * share;
  }
  return make(w1, w2);
}

}  // namespace hrp::walking
