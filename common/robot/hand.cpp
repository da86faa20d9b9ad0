// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/hand.h"

#include <cmath>

#include "common/spatial/minimum_jerk.h"

namespace hrp {
namespace {

constexpr double kTurn = 2.0 * M_PI;

// From point to point, at rest in each.
void add_path(const HandSpec& hand, double time, HandPlace* place) {
  HandPoint from;
  for (const HandPoint& to : hand.path) {
    const double span = to.time - from.time;
    if (time < to.time && span > 0.0) {
      const double s = (time - from.time) / span;
      const Vector3d way = to.p_QH_W - from.p_QH_W;
      place->p += from.p_QH_W + calc_minimum_jerk(s) * way;
      place->v += calc_minimum_jerk_rate(s) / span * way;
      return;
    }
    from = to;
  }
  place->p += from.p_QH_W;
}

// Grows in and fades out; envelope and its derivative.
void calc_envelope(const HandWave& wave, double time, double* envelope, double* rate) {
  const double t = time - wave.start, left = wave.duration - t, fade = std::max(wave.fade, 1e-9);
  const double in = calc_minimum_jerk(t / fade), in_rate = calc_minimum_jerk_rate(t / fade) / fade;
  const bool ends = wave.duration > 0.0;
  const double out = ends ? calc_minimum_jerk(left / fade) : 1.0;
  const double out_rate = ends ? -calc_minimum_jerk_rate(left / fade) / fade : 0.0;
  *envelope = in * out;
  *rate = in_rate * out + in * out_rate;
}

}  // namespace

HandPlace calc_hand_place(const HandSpec& hand, double time) {
  HandPlace place;
  add_path(hand, time, &place);
  for (const HandWave& wave : hand.waves) {
    double envelope = 0.0, rate = 0.0;
    calc_envelope(wave, time, &envelope, &rate);
    const double w = kTurn * wave.frequency, angle = w * time + wave.phase;
    place.p += envelope * std::sin(angle) * wave.amplitude_W;
    place.v += (rate * std::sin(angle) + envelope * w * std::cos(angle)) * wave.amplitude_W;
  }
  return place;
}

Vector3d calc_hand_force(const HandSpec& hand, const Vector3d& p_QH, const Vector3d& v_QH) {
  return hand.stiffness_W.cwiseProduct(p_QH) + hand.damping_W.cwiseProduct(v_QH);
}

}  // namespace hrp
