// SPDX-License-Identifier: BSD-3-Clause
// One effect of the table at one place of a robot, with values: what hypotheses are made of.
#pragma once

#include <tuple>
#include <utility>
#include <vector>

#include "common/effects/effect_info.h"
#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// What of a sensor's readings an effect is of.
enum class Reading {
  kAll,
  kPosition,
  kVelocity,
  kEffort,  // of a joint; kPosition also of a tracked body
  kWrench,
  kForce,
  kTorque,  // of a force sensor: both, or one
  kImu,
  kOrientation,
  kAngularVelocity,
  kAcceleration  // of an IMU: all, or one
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
  bool operator!=(const Place& other) const { return !(*this == other); }
  bool operator<(const Place& other) const {
    return std::tie(kind, index, reading) < std::tie(other.kind, other.index, other.reading);
  }
};

inline Place at_joint(int joint) { return {PlaceKind::kJoint, joint, Reading::kAll}; }
inline Place at_link(int link) { return {PlaceKind::kLink, link, Reading::kAll}; }
inline Place at_sensor(int index, Reading reading) { return {PlaceKind::kSensor, index, reading}; }
// One clock, or all drives' loops: of the whole recording.
inline Place at_all() { return {PlaceKind::kNone, 0, Reading::kAll}; }

// Signals of joints are numbered joint by joint: position, velocity, effort.
inline Place at_signal(int signal) {
  return at_sensor(signal / kQuantities,
                   static_cast<Reading>(static_cast<int>(Reading::kPosition) + signal % kQuantities));
}
inline int get_signal(const Place& place) {
  return place.index * kQuantities + static_cast<int>(place.reading) - static_cast<int>(Reading::kPosition);
}

// Readings of a joint are one number each, all others are vectors.
inline bool is_of_joint(Reading reading) {
  return reading == Reading::kPosition || reading == Reading::kVelocity || reading == Reading::kEffort;
}

// Values of the parameters that are fitted, in the table's order; what an engine writes otherwise stands there.
struct Effect {
  Effect() = default;
  Effect(EffectId row, const Place& at, std::vector<double> values) : id(row), place(at), p(std::move(values)) {}
  // At the joint or link of that number, of which the row is; a reading of a sensor has to be said.
  Effect(EffectId row, int index, std::vector<double> values);

  EffectId id = kNoEffect;
  Place place;
  std::vector<double> p;
};
using Hypothesis = std::vector<Effect>;

// The simpler effect that another one has as a part, and whether the one row has the other as a part.
Effect make_part(const Effect& whole, const EffectPart& part);
bool has_part(EffectId whole, EffectId part);

}  // namespace hrp::diagnosis
