// SPDX-License-Identifier: BSD-3-Clause
// A gyroscope or an accelerometer whose columns have another sign or order than the model's axes, while the other half
// of the IMU is right. A whole IMU can only be turned; columns of one quantity may be left-handed as well.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "diagnosis/floating/checks/imu_over_legs.h"

namespace hrp::diagnosis::floating {

// [1] By moment, what is left of an IMU in such axes.
using LeftInAxes = std::function<std::vector<double>(const ImuAxes& axes)>;

struct SignedAxes {
  ImuAxes axes;
  double left = 1.0;  // share in squares
};

// The columns of one quantity that leave a quarter, with odds of 20 to 1 against `as_taken`, which is what is left
// without, and against every reading that changes fewer columns. Identities where none does. Then the other quantity
// beside it.
SignedAxes find_signed_axes(const std::vector<Instant>& at, const LeftInAxes& left, const std::vector<double>& as_taken,
                            bool has_accelerometer);

// R = Q D: a turn, and signs of axes where R is left-handed; of those that make it, the smallest turn. A sensor that is
// so turned and counts with these signs reads R^T of the truth.
struct TurnAndSigns {
  Matrix3d Q = Matrix3d::Identity();
  Vector3d signs{1.0, 1.0, 1.0};
};
TurnAndSigns split_signs(const Matrix3d& R);

// "x -y z"
std::string name_columns(const Matrix3d& R);

}  // namespace hrp::diagnosis::floating
