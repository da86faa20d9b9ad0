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

// Values of the parameters that are fitted, in the table's order; what an engine writes otherwise stands there.
struct PlacedEffect {
  EffectId id = EffectId::kNamed;
  Place place;
  std::vector<double> p;
};
using PlacedHypothesis = std::vector<PlacedEffect>;

// Values for the table's apply(): defaults where none is fitted.
std::vector<double> make_values(const PlacedEffect& effect);
}  // namespace hrp::diagnosis
