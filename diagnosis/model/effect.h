// SPDX-License-Identifier: BSD-3-Clause
// One effect of the table at one place of a robot, with values: what hypotheses are made of.
#pragma once

#include <vector>

#include "common/effects/effect_info.h"

namespace hrp::diagnosis {

// What of a sensor's readings an effect is of.
enum class Reading {
  kAll,
  kPosition, kVelocity, kEffort,                      // of a joint; kPosition also of a tracked body
  kWrench, kForce, kTorque,                           // of a force sensor: both, or one
  kImu, kOrientation, kAngularVelocity, kAcceleration // of an IMU: all, or one
};
const char* get_unit(Reading reading);  // of a joint's, a force sensor's or an IMU's single readings

// `index`: of the joint, link or foot; of the joint whose position, velocity or effort is read, else of the sensor.
struct Place {
  PlaceKind kind = PlaceKind::kJoint;
  int index = 0;
  Reading reading = Reading::kAll;
  bool operator==(const Place& other) const {
    return kind == other.kind && index == other.index && reading == other.reading;
  }
};

inline Place at_joint(int joint) { return {PlaceKind::kJoint, joint, Reading::kAll}; }
inline Place at_link(int link) { return {PlaceKind::kLink, link, Reading::kAll}; }
inline Place at_sensor(int index, Reading reading) { return {PlaceKind::kSensor, index, reading}; }

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
