// SPDX-License-Identifier: BSD-3-Clause
// Sensors of a body that count otherwise than SI units: accelerometers in g or with the sign of gravity, gyroscopes in
// degrees, forces that the foot does to the ground, positions in millimetres. Drivers differ in nothing more than in
// these. Left as they are, one of them makes the faults of all others: a body that weighs a tenth, forces ten times too
// large.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis::floating {

struct BodyUnit {
  std::string sensor;     // "/imu/root/linear_acceleration": its columns are that and an axis
  double scale = 1.0;     // reading over SI value
  std::string meaning;    // "it counts in g"
  bool may_hang = false;  // or else the sensor is turned by half a turn, about an axis that nothing tells
};

// Of a floating base whose recordings tell; upright most of the time.
std::vector<BodyUnit> find_body_units(const Experiment& experiment);

// The same experiment with readings in SI units.
Experiment convert_body_units(Experiment experiment, const std::vector<BodyUnit>& units);

}  // namespace hrp::diagnosis::floating
