// SPDX-License-Identifier: BSD-3-Clause
// What encoders of legs that stand say of the body: how it turns, and where up is. No IMU, pose or force is asked, nor
// which feet stand: at each moment, those do that fit best what is compared with them.
#pragma once

#include <vector>

#include "diagnosis/floating/log/body_motion.h"

namespace hrp::diagnosis::floating {

// To which soles that lie flat tell a body's motion: how it turns [rad/s], its tilt [rad], and with it the direction of
// an accelerometer's reading [m/s^2].
constexpr double kRateOfSoles = 0.02, kTiltOfSoles = 0.03, kForceOfSoles = 0.3;

// Feet that may stand: a flat one, or two balls. In the base's axes.
struct StandingFeet {
  Matrix3d A, B;  // A w = turn, w [rad/s] the base's rate; B u = level, u the unit vector upwards
  Vector3d turn, level;
  Vector3d below;  // about where they are
};

// Flat feet, else pairs of balls: their distance does not turn in the world, and level ground holds it level.
std::vector<StandingFeet> list_standing_feet(const LeggedLog& log, BodyMotion* motion);

// Where nothing tells up: then only the turning counts.
void forget_up(std::vector<StandingFeet>* feet);

// The least that any of them leaves [1]: in squares, over what soles and encoders tell. `up`: a vector upwards, of 1.
double calc_left(const std::vector<StandingFeet>& feet, const Vector3d& rate, const Vector3d& up);

}  // namespace hrp::diagnosis::floating
