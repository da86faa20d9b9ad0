// SPDX-License-Identifier: BSD-3-Clause
// A gyroscope against how the body turns by others: scale and turn of its axes, whatever its zero is.
#pragma once

#include <vector>

#include "common/spatial/transform.h"

namespace hrp::diagnosis::floating {

// What somebody says of the sensor's true rate w [rad/s], in the sensor's axes by the model: A w = turn.
struct RateToldBy {
  Matrix3d A;
  Vector3d turn;
};

// One moment. Of several that may tell it, the one that leaves least does: of two feet, one may swing.
struct RateMoment {
  int recording = 0, block = 0;
  Vector3d reading;
  std::vector<RateToldBy> told;
};

// true rate = R(turn) reading / scale - zero
struct GyroMap {
  Vector3d turn{0, 0, 0};                       // [rad] a rotation vector
  Matrix3d turn_covariance = Matrix3d::Zero();  // beside the prior: what no motion tells stays near zero
  double scale = 1, scale_std = 0;              // [1]
  double turn_left = 1, scale_left = 1;         // share of the squares without it that is left with it
  double usual = 0, of_another_time = 0;      // [rad/s] median of what is left; of readings of another time, by chance
  bool told = false;                          // there are enough blocks
  bool may_be_turned = false;                 // beyond chance, and the same in all recordings
  bool is_turned = false, is_scaled = false;  // that, and a tenth of the squares goes with it
};

GyroMap find_gyro_map(const std::vector<RateMoment>& moments);

}  // namespace hrp::diagnosis::floating
