// SPDX-License-Identifier: BSD-3-Clause
// Angles and torques of the sole's bush from joint encoders, chest IMU and ankle force sensors, with the grounded sole
// as base [M14]: the sole lies flat, so the vertical seen from the foot's upper part gives roll and pitch of the bush.
// One foot on the floor or both (tree, closed chain): which, the force sensors say (standing.h).
//
// Frames: I IMU, U upper part of a foot, S sole (foot_frame.h). The vertical n in I comes from the gyroscope; its slow
// drift is taken out by the accelerometer, whose own acceleration is computed along the chain from the sole.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "diagnosis/identification/attitude.h"
#include "diagnosis/identification/robot_log.h"
#include "diagnosis/identification/standing.h"

namespace hrp::identification {

constexpr int kAxes = 2;  // roll, pitch
extern const char* const kAxisNames[kAxes];
constexpr double kSmoothing = 0.03;  // [s] of tracks: passes what bushes answer to (up to 6 Hz), stops the noise
constexpr int kThinning = 4;         // of tracks: smoothed samples are alike

// One foot's bush during one motion; smoothed and thinned.
struct BushTrack {
  Eigen::VectorXd angle[kAxes];         // [rad]
  Eigen::VectorXd quick[kAxes];         // [rad] at every sample of the log, hardly smoothed: for what remembers
  Eigen::VectorXd rate[kAxes];          // [rad/s]
  Eigen::VectorXd acceleration[kAxes];  // [rad/s^2]
  Eigen::VectorXd torque[kAxes];        // [N m] that acts on U about the bush's axes: K q + C qd + O [M14 eq. 4]
  Eigen::MatrixXd angle_gain[kAxes];    // d angle / d IMU errors, sample by sample
  Eigen::MatrixXd rate_gain[kAxes];     // d rate / d IMU errors
  // d torque / d vertical compliance [N m/(m/N)]: under load the axes come nearer to the ankle by compliance x load.
  Eigen::VectorXd arm[kAxes];
  Eigen::VectorXd load;  // [N] vertical force on the bush
  Eigen::Matrix2Xd zmp;  // [m] centre of pressure under the bush's centre, sole axes
  // Vertical: acceleration of the slide as encoders and accelerometer have it [m/s^2] (chain less sensor), and the
  // second to fourth derivatives of the load [N/s^2], [N/s^3], [N/s^4].
  Eigen::VectorXd slide_acceleration, load_derivative[3];
  Eigen::VectorXd rise, rise_rate;  // [m/s^2], [m/s^3] vertical acceleration of the IMU as the sensor has it
};

struct MotionTrack {
  std::string name;
  Eigen::VectorXd time;     // [s]
  double period = 0.0;      // [s]
  double log_period = 0.0;  // [s] of the log
  // A signal of the log (or its derivative, by `order`) as all signals of a track are: smoothed and thinned.
  Eigen::VectorXd thin(const Eigen::VectorXd& signal, int order) const;
  std::vector<BushTrack> feet;
  // [m] first foot's bush slide less the second's, less its mean; empty unless both always stand
  Eigen::VectorXd slide;
  // [m, m, rad] place of the second foot's bush on the floor, in the first sole
  Vector3d second_sole = Vector3d::Zero();
  // In a stretch of time in which both feet stand (one that was lifted may come down elsewhere):
  double slip = 0.0;     // [m] largest change of the distance between the soles from its median
  double turn = 0.0;     // [rad] same for the yaw between them
  double slipped = 0.0;  // [s] of stretches with too much of either: neither foot is taken to stand there
  // By foot, sample by sample: stands. While it does not, its angles are not those of a level sole and its torque is
  // that of a hanging one.
  std::vector<Mask> stands;
  // Of those, what began at least `skip` seconds ago, or where the track begins.
  Mask find_usable(size_t foot, double skip) const;
  double calc_standing_time(size_t foot) const { return period * static_cast<double>(stands[foot].count()); }  // [s]
};

// Soles that moved on the floor: their distance or the yaw between them changed more than rubber lets them. Simulated
// soles that hold move by less than 0.1 mm and 0.1 mrad.
constexpr double kSlipDistance = 1e-3;  // [m]
constexpr double kSlipTurn = 0.005;     // [rad]
bool has_slipped(const MotionTrack& track);

// How the sole hangs on its bush while the feet are in the air [rad].
using HangingAngles = std::array<double, kAxes>;

// Mean error of a force sensor, from a record of the robot hanging free; covariance of that mean.
struct SensorZero {
  Vector6d bias = Vector6d::Zero();       // [N; N m]
  Vector3d gyro_bias = Vector3d::Zero();  // [rad/s] of the IMU in the same record
  double gyro_std = 5e-3;                 // [rad/s] of that; without a record, what MEMS gyroscopes are off
  double lift = 0.0;                      // [m/s^2] what the accelerometer had beyond gravity: its bias along z
  Matrix6d covariance = Matrix6d::Zero();
};

class BushObserver {
 public:
  // The robot as its URDF describes it; of the scenario's bush only the place (centre, share of mass) is used.
  explicit BushObserver(const Scenario& scenario);
  ~BushObserver();
  BushObserver(BushObserver&&) noexcept;
  // Zero of the force sensors while the feet hang in the air (still but for the first seconds; feet weigh what the URDF
  // says, and soles hang straight unless `angles` says by foot how the bush's offset tilts them).
  std::vector<SensorZero> calc_zeros(const RobotLog& all, const std::vector<HangingAngles>& angles = {}) const;
  // Tilt of a hanging sole on a bush with these stiffnesses and offsets: 0 = K q + O - moment of its weight.
  HangingAngles calc_hanging(size_t foot, const double (&K)[kAxes], const double (&O)[kAxes]) const;
  MotionTrack observe(const RobotLog& log, const std::vector<SensorZero>& zeros) const;
  // R_WI of the IMU sample by sample, W level and, but for the gyroscope's slow drift, not turning.
  std::vector<Matrix3d> calc_attitude(const RobotLog& log, const std::vector<SensorZero>& zeros) const;
  const std::vector<FootFrame>& feet() const;
  std::vector<Vector3d> bush_centres() const;  // [m] in the foot links

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hrp::identification
