// SPDX-License-Identifier: BSD-3-Clause
// What is assumed to be real: the experiment's nominal model plus a list of effects with parameters.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/multibody/model.h"
#include "diagnosis/data/recording.h"
#include "servers/dynamics/joint_law.h"

namespace hrp::diagnosis {

enum class EffectId {
  kViscous, kCoulomb, kStribeck, kLoadFriction, kRotorInertia, kElasticity, kBacklash, kTorqueConstant, kSaturation,
  kLag, kDelay, kSpring, kCogging, kHysteresis, kJointOffset,
  kPayload, kMassError, kComError, kExternalForce,
  kSensorBias, kSensorScale, kSensorDelay, kClockSkew,
  kTiming,       // of the drives' own loops: never reported, fitted along with everything else
  kDriveTiming,  // the same of one drive alone, behind a transmission that gives
  kCount
};

enum class PlaceKind { kJoint, kLink, kJointSensor, kNone };

struct ParameterInfo {
  const char* name;
  const char* unit;
  double low, high;   // bounds
  double step;        // natural size: finite differences and start values
  bool nuisance;      // fitted but not part of the effect's definition
  bool scanned = false;  // readings are no smooth function of it: the best of a few values, see starts.cpp
  bool walked = false;   // fitted, but from the best of the values around, see nearby.h
};

struct EffectInfo {
  EffectId id;
  const char* name;
  PlaceKind place;
  const char* phrase;  // completes "Joint x: ..."
  std::vector<ParameterInfo> parameters;
};

const EffectInfo& get_effect(EffectId id);

struct Effect {
  EffectId id = EffectId::kViscous;
  int place = 0;                // joint, link, or joint * 3 + quantity for sensors of joints
  std::vector<double> p;        // values, order of EffectInfo::parameters
};

using Hypothesis = std::vector<Effect>;

std::string get_place_text(const Experiment& e, const Effect& effect);   // "elbow_pitch"
std::string get_label(const Experiment& e, const Effect& effect);        // "coulomb_friction@elbow_pitch"
std::string get_label(const Experiment& e, const Hypothesis& hypothesis);

// [s] damping of a transmission over its stiffness that fits start from.
constexpr double kGearLoss = 0.002;

// Which effects at which places, whatever their parameters and order.
using EffectSet = std::vector<std::pair<int, int>>;
EffectSet make_set(const Hypothesis& hypothesis);
// Whether an effect is in a hypothesis at a place, with whatever parameters.
bool contains(const Hypothesis& hypothesis, EffectId id, int place);

// Of the drives' loops: last in a hypothesis.
bool is_timing(const Effect& effect);

// [rad] displacement before slipping of rolling and sliding contacts in gears, where nothing is known.
constexpr double kPresliding = 5e-4;

struct SignalFault {
  double bias = 0.0, scale = 1.0, delay = 0.0;
};

struct Plant {
  TreeSpec tree;
  std::shared_ptr<const Model> model;
  std::vector<JointLaws> laws;          // by joint
  std::vector<double> rotor;            // [kg m^2] reflected inertia added by effects
  std::vector<Vector3d> force_W;        // [N] by link at its centre of mass, empty: none
  std::vector<SignalFault> faults;      // by joint * 3 + quantity
  double rate_lag = 0.0;                // [s] by which the servo's velocity lags behind its position
  double clock_skew = 0.0;              // states' clock runs (1 + skew) as fast as the commands'
  bool effort_driven = false;
  std::vector<double> presliding;       // [rad] by joint: at it dry friction reaches its largest value
  double command_shift = 0.0;           // [s] by which the stamps of commands run ahead of those of readings
};

Plant make_plant(const Experiment& e, const Hypothesis& hypothesis);

}  // namespace hrp::diagnosis
