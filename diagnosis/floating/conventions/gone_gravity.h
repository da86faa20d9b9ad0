// SPDX-License-Identifier: BSD-3-Clause
// Accelerometers whose log holds no gravity: zeroed at rest, or by a filter that takes gravity out ("linear
// acceleration"). A body that stays on its feet feels its weight on average, so that a mean of nothing is told without
// any other sensor.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis::floating {

struct GoneGravity {
  std::string sensor;       // "/imu/root/linear_acceleration"
  Vector3d value{0, 0, 0};  // [m/s^2] that is missing in the sensor's axes while the body stands as it does on average
  double left = 0.0;        // [m/s^2] size of its mean reading
  bool follows = false;     // what is missing turns with the body: a filter that knows up took it out
  Matrix3d R_LI = Matrix3d::Identity();  // of the sensor in its link
};

// Of a floating base with feet.
std::vector<GoneGravity> find_gone_gravity(const Experiment& experiment);

// The same experiment with gravity in its accelerometers again: upwards on average, or at each sample by the attitude.
Experiment return_gravity(Experiment experiment, const std::vector<GoneGravity>& gone);

}  // namespace hrp::diagnosis::floating
