// SPDX-License-Identifier: BSD-3-Clause
// Stiffness, damping and offset of the bushes from tracks of several motions.
//
//   tau = K q + C qd + O                 per foot and axis            [M14 eq. 4, 5, 6]
//   all motions one below the other      one set of parameters        [M14 eq. 7]
//
// Beside them the accelerometer's bias, which all motions, feet and axes share: it turns the estimated vertical and would
// pass for an offset. Turning the waist tells the two apart, as the bias turns with the chest.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "diagnosis/identification/bush_angles.h"

namespace hrp::identification {

enum class BushLaw { kLinear, kHardening };  // hardening: tau = K q (1 + (q / h)^2) + C qd + O

struct Estimate {
  double value = 0.0, std = 0.0;
  double relative_std() const { return std / std::abs(value); }  // [M14] table 1
};

struct BushParameters {
  Estimate K;       // [N m/rad]
  Estimate C;       // [N m s/rad]
  Estimate O;       // [N m]
  Estimate cubic;   // [N m/rad^3] K / h^2; zero for the linear law
};

struct FitOptions {
  BushLaw law = BushLaw::kLinear;
  // What noise makes of angle and rate, (angle, rate) by foot and axis: taken off the normal equations, which would
  // otherwise see noise as motion and give too small values (errors in variables). Empty: nothing is taken off.
  std::vector<std::array<Eigen::Matrix2d, kAxes>> noise;
  double error_memory = 6.0;    // [s] over which residuals are alike: for the standard deviations
};

struct BushFit {
  BushLaw law = BushLaw::kLinear;
  std::vector<std::array<BushParameters, kAxes>> feet;
  Vector3d accelerometer_bias = Vector3d::Zero();      // [m/s^2] along the IMU's x and y; z does not show
  Vector3d accelerometer_bias_std = Vector3d::Zero();
  std::vector<std::array<double, kAxes>> residual;     // [N m] root mean square by foot and axis
  double condition = 0.0;                              // of the scaled regressor
  std::vector<std::string> constrained;                // parameters held at zero: K, C, cubic are never negative
};

// Throws std::runtime_error when the tracks cannot tell the parameters. Tracks whose foot does not carry load all the
// time, or slips, are left out for that foot.
BushFit fit_bush(const std::vector<MotionTrack>& tracks, const std::vector<SensorZero>& zeros,
                 const std::vector<Vector3d>& arms, const FitOptions& options = {});

// Torque that a fit predicts along a track.
Eigen::VectorXd predict_torque(const BushFit& fit, const MotionTrack& track, size_t foot, int axis);

// Covariance of (angle, rate) of a robot that does not move: what noise alone does.
std::vector<std::array<Eigen::Matrix2d, kAxes>> calc_angle_noise(const MotionTrack& resting);

// Errors of a validation, tables 2 and 3 of [M14].
struct ValidationError {
  std::string motion;
  size_t foot = 0;
  int axis = 0;
  double mean = 0.0;      // [N m] mean absolute error
  double largest = 0.0;   // [N m] of the measured torque
  double relative() const { return mean / largest; }
};
std::vector<ValidationError> validate(const BushFit& fit, const std::vector<MotionTrack>& tracks);

// The law that predicts motions it has not seen best: each motion in turn is left out of the fit. The simpler law stays
// unless the other one lowers the error by a tenth and its cubic terms are four standard deviations from zero.
struct LawChoice {
  BushLaw law = BushLaw::kLinear;
  double linear_error = 0.0, hardening_error = 0.0;  // [N m] root mean square on motions left out
  double significance = 0.0;                         // largest cubic term over its standard deviation
};
LawChoice choose_law(const std::vector<MotionTrack>& tracks, const std::vector<SensorZero>& zeros,
                     const std::vector<Vector3d>& arms);

// Soles that moved on the floor: their distance or the yaw between them changed more than rubber lets them.
// Simulated soles that hold creep by up to 2 mm in 20 s while the feet are twisted on them.
constexpr double kSlipDistance = 4e-3;  // [m]
constexpr double kSlipTurn = 0.015;     // [rad]
bool has_slipped(const MotionTrack& track);

// Vertical compliance [m/N] of both feet from the closed chain: slide = load_1 / k_1 - load_2 / k_2 + constant.
std::vector<Estimate> fit_vertical_compliance(const std::vector<MotionTrack>& tracks);

}  // namespace hrp::identification
