// SPDX-License-Identifier: BSD-3-Clause
// Attitude of an IMU: the gyroscope integrated, and what drifts slowly beside it.
#pragma once

#include <vector>

#include "common/spatial/gravity.h"
#include "diagnosis/identification/robot_log.h"

namespace hrp::identification {

// Errors of the IMU that all motions share: accelerometer bias x, y, z [m/s^2], delay of the gyroscope [s], what is
// left of its bias x, y [rad/s] (z hardly turns the vertical).
constexpr int kDelay = 3;
constexpr int kGyroBias = 4;  // and 5
constexpr int kImuErrors = 6;

// Attitude by the gyroscope alone, from any start: integrated axes from those of the IMU.
std::vector<Matrix3d> integrate_gyro(const RobotLog& log, const Vector3d& bias);

// The vertical in gyroscope-integrated axes, slowly drifting: a line by least squares, then a wide smoother. `margin`
// samples at both ends are left out, where the robot's acceleration is not known; there the drift is held.
Samples smooth_drift(const Samples& all, Eigen::Index margin, double period);

// The vertical in the IMU's axes as estimated, and what that rests on.
struct VerticalEstimate {
  std::vector<Matrix3d> R;  // integrate_gyro
  Samples n_I;
  Samples gain[kImuErrors];  // what each error of the IMU does to n_I
};
// Fills `gain`. The drift smoother mends the slow part of what the gyroscope does.
void fill_gains(const RobotLog& log, const Vector3d& gyro_bias, Eigen::Index margin, VerticalEstimate* vertical);

}  // namespace hrp::identification
