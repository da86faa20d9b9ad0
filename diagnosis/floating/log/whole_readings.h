// SPDX-License-Identifier: BSD-3-Clause
// Force sensors whose link has a mass. The model has the sensor above that link, as an ankle's is: its reading leaves
// the foot's own weight and inertia out. Some logs hold what the ground does to the whole foot. Feet in the air show
// which.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis::floating {

struct ForceSensor;  // legged_log.h

// [kg] That the model has below a sensor, whether it is part of the mechanism above the sensor or not.
double find_mass_below(const ForceSensor& sensor);

struct WholeReading {
  std::string sensor;  // "l_foot" of "/wrench/l_foot"
  double mass = 0;     // [kg] below it by the model
  double air = 0;      // [N] that it reads upwards with the foot in the air
  // The log keeps no smaller forces, and the feet carry what hangs above the sensors: the foot hangs on its sensor, and
  // nothing tells how it pulls at it in the air.
  bool cut = false;
};

// All sensors of feet with a mass, if all read the whole foot in the air; else none.
std::vector<WholeReading> find_whole_readings(const Experiment& experiment);

Experiment convert_whole_readings(Experiment experiment, const std::vector<WholeReading>& readings);

// "/wrench/l_foot: it reads what the ground does to the whole foot: ..."
std::string describe(const WholeReading& reading);

}  // namespace hrp::diagnosis::floating
