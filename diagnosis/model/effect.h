// SPDX-License-Identifier: BSD-3-Clause
// One effect of the table at one place of a robot, with values: what hypotheses are made of.
#pragma once

#include <vector>

#include "common/effects/effect_info.h"

namespace hrp::diagnosis {

// What of a sensor's readings an effect is of.
enum class Reading { kAll, kPosition, kVelocity, kEffort, kForce, kTorque };

// `index`: of the joint, link or foot; of the joint whose position, velocity or effort is read, else of the sensor.
struct Place {
  PlaceKind kind = PlaceKind::kJoint;
  int index = 0;
  Reading reading = Reading::kAll;
  bool operator==(const Place& other) const {
    return kind == other.kind && index == other.index && reading == other.reading;
  }
};

// Readings of a joint are one number each, all others are vectors.
inline bool is_of_joint(Reading reading) {
  return reading == Reading::kPosition || reading == Reading::kVelocity || reading == Reading::kEffort;
}

// Values in the order of list_coordinates().
struct PlacedEffect {
  EffectId id = EffectId::kNamed;
  Place place;
  std::vector<double> p;
};
using PlacedHypothesis = std::vector<PlacedEffect>;

// One number of an effect in which residuals are linear, or nearly so: a parameter of the table, or, where the table
// has columns of torque for parameters that are not (the rest of a spring without stiffness), their coefficient.
struct Coordinate {
  const EffectParameter* parameter = nullptr;
  double neutral = 0.0;   // at which the effect is absent
  double step = 0.0;      // of finite differences
  bool positive = false;  // below neutral it means nothing
};
std::vector<Coordinate> list_coordinates(EffectId id, const Place& place);

// Coordinates are coefficients of the table's columns of torque.
bool has_columns(EffectId id);

PlacedEffect make_absent(EffectId id, const Place& place);
bool contains(const PlacedHypothesis& hypothesis, EffectId id, const Place& place);

// Values for the table's apply(): defaults where there is no coordinate. Not for effects with columns.
std::vector<double> make_values(const PlacedEffect& effect);
// Parameters as a report has them, with standard deviations from those of the coordinates.
struct ParameterValues {
  std::vector<const EffectParameter*> parameters;
  std::vector<double> value, std;
};
ParameterValues make_parameter_values(const PlacedEffect& effect, const std::vector<double>& std);

}  // namespace hrp::diagnosis
