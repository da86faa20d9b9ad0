// SPDX-License-Identifier: BSD-3-Clause
// Closed forms of contact.
#pragma once

namespace hrp::solutions {

// [m/s^2] along a slope steeper than the friction angle: g (sin a - mu cos a).
double calc_slide_acceleration(double gravity, double slope, double friction);

// Rebound over landing speed v0 of a mass on f = k x^n (1 + d xdot), d = 3/2 alpha, without weight. Dividing the motion
// equation m v dv = -k x^n (1 + d v) dx by (1 + d v) and integrating both ways gives, with e v0 the rebound speed,
//   d (v0 + e v0) = ln((1 + d v0) / (1 - d e v0))
// for every k, m and n. For small v0: e = 1 - alpha v0.
double calc_hunt_crossley_restitution(double v0, double alpha);

// The same with the damper only on the way in: e^2 v0^2 / 2 = v0 / d - ln(1 + d v0) / d^2.
double calc_one_sided_restitution(double v0, double alpha);

}  // namespace hrp::solutions
