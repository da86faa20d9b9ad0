// SPDX-License-Identifier: BSD-3-Clause
// Stiffness, damping and offset of the bushes from tracks of several motions.
//
//   tau = K q + C qd + O                 per foot and axis            [M14 eq. 4, 5, 6]
//   all motions one below the other      one set of parameters        [M14 eq. 7]
//
// Beside them what all motions share and what would pass for these parameters: the accelerometer's bias turns the
// estimated vertical like an offset (turning the waist tells the two apart: the bias turns with the chest) and, along
// the sensor's z, makes the chest seem to tilt more than it does; a late gyroscope looks like damping (feet that turn
// while the chest is still tell them apart); the vertical compliance brings the bush's axes nearer to the ankle (a
// horizontal force then turns the bush); the inertia of what is between force sensor and bush, less that of a damper
// that acts late, makes quick motions seem stiffer than slow ones.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "diagnosis/identification/bush_angles.h"
#include "diagnosis/identification/least_squares.h"

namespace hrp::identification {

// tau = K q + C qd + O, with hardening + B q^3, B = K / h^2; with hysteresis + H z, H = (Bouc-Wen stiffness) x yield.
enum class BushLaw { kLinear, kHardening, kHysteresis };
constexpr int kLaws = 3;
extern const char* const kLawNames[kLaws];

struct BushParameters {
  Estimate K;           // [N m/rad]
  Estimate C;           // [N m s/rad]
  Estimate O;           // [N m]
  Estimate J;           // [kg m^2] apparent inertia between force sensor and bush, of either sign
  Estimate cubic;       // [N m/rad^3] B; zero but for the hardening law
  Estimate hysteresis;  // [N m] H; zero but for the hysteretic law
};

struct FitOptions {
  BushLaw law = BushLaw::kLinear;
  // What noise makes of angle and derivatives, (angle, rate, acceleration) by foot and axis: taken off the normal
  // equations, which would otherwise see noise as motion and give too small values (errors in variables). Empty:
  // nothing is taken off.
  std::vector<std::array<Matrix3d, kAxes>> noise;
  double error_memory = 10.0;  // [s] window for residuals that are alike over 2 s: for the standard deviations
  double skip = 0.0;           // [s] where a track begins or a foot has come down: hysteresis remembers what was before
  double yield = 0.0;  // [rad] hysteretic law: where the search for a yield angle starts; 0: at several, the best wins
  std::vector<Estimate> compliance;  // [m/N] vertical, by foot, where known from elsewhere (vertical.h)
};

struct BushFit {
  BushLaw law = BushLaw::kLinear;
  double skip = 0.0;  // [s] as in the options
  std::vector<std::array<BushParameters, kAxes>> feet;
  std::vector<Estimate> compliance;                 // [m/N] vertical, by foot
  Estimate accelerometer_bias[3];                   // [m/s^2] sensor axes; z scales how much the chest seems to tilt
  Estimate gyro_bias[2];                            // [rad/s] x, y, beyond the hanging robot's mean
  Estimate delay;                                   // [s] of the gyroscope against encoders and force sensors
  Estimate yield;                                   // [rad] hysteretic law; std of its logarithm times it
  std::vector<std::array<double, kAxes>> residual;  // [N m] root mean square by foot and axis
  double condition = 0.0;                           // of the scaled regressor
  std::vector<std::string> constrained;             // parameters held at zero: K, C, B, H are never negative
  Eigen::VectorXd theta;                            // all of them, for predict_torque
};

// Throws std::runtime_error when the tracks cannot tell the parameters. Tracks with slip are left out, and so is a foot
// while it does not stand.
BushFit fit_bush(const std::vector<MotionTrack>& tracks, const std::vector<SensorZero>& zeros,
                 const std::vector<Vector3d>& arms, const FitOptions& options = {});

// Torque that a fit predicts along a track.
Eigen::VectorXd predict_torque(const BushFit& fit, const MotionTrack& track, size_t foot, int axis);

// Covariance of (angle, rate, acceleration) of a robot that does not move: what noise alone does.
std::vector<std::array<Matrix3d, kAxes>> calc_angle_noise(const MotionTrack& resting);

// What is left out where hysteresis may still remember what no track shows [s].
constexpr double kForget = 2.0;

// Errors of a validation, tables 2 and 3 of [M14]: while the foot stands.
struct ValidationError {
  std::string motion;
  size_t foot = 0;
  int axis = 0;
  double time = 0.0;     // [s] that the foot stood
  double mean = 0.0;     // [N m] mean absolute error
  double largest = 0.0;  // [N m] of the measured torque
  double relative() const { return mean / largest; }
};
std::vector<ValidationError> validate(const BushFit& fit, const std::vector<MotionTrack>& tracks);

// The law that predicts motions it has not seen best: each motion in turn is left out of the fit. The linear law stays
// unless another one lowers the error by a tenth and one of its terms is four standard deviations from zero.
struct LawChoice {
  BushLaw law = BushLaw::kLinear;
  double error[kLaws] = {};         // [N m] root mean square on motions left out
  double significance[kLaws] = {};  // largest additional term over its standard deviation
};
LawChoice choose_law(const std::vector<MotionTrack>& tracks, const std::vector<SensorZero>& zeros,
                     const std::vector<Vector3d>& arms, const FitOptions& options = {});

}  // namespace hrp::identification
