// SPDX-License-Identifier: BSD-3-Clause
// Which equation a channel is.
#pragma once

#include <string>

namespace hrp::diagnosis::floating {

enum class EquationKind {
  kMoment,
  kForce,   // balance of the whole body
  kWeight,  // its vertical part alone
  kJoint,
  kServo,              // a drive's torque against inverse dynamics, and against its servo law
  kGyroscope,          // against another measured rate
  kGyroscopeOverFeet,  // against encoders over feet that stand
  kAccelerometer,
  kGravity,  // sample by sample, and its mean over time
  kTilt,
  kHeight,  // of soles on the ground
  kLegMoment,
  kLegForce  // balance of the whole body with forces of the feet that torques of standing legs tell
};

struct Equation {
  Equation() = default;
  Equation(EquationKind k, int a = -1) : kind(k), axis(a) {}
  bool operator==(const Equation& o) const { return kind == o.kind && axis == o.axis; }
  bool is(EquationKind k) const { return kind == k; }
  bool is_balance() const { return is(EquationKind::kMoment) || is(EquationKind::kForce); }
  bool is_balance_by_legs() const { return is(EquationKind::kLegMoment) || is(EquationKind::kLegForce); }
  bool is_of_whole_body() const { return is_balance() || is_balance_by_legs(); }
  bool is_gyroscope() const { return is(EquationKind::kGyroscope) || is(EquationKind::kGyroscopeOverFeet); }
  bool is_vertical_force() const { return is(EquationKind::kWeight) || *this == Equation(EquationKind::kForce, 2); }

  EquationKind kind = EquationKind::kWeight;
  int axis = -1;  // x, y, z; of a tilt roll, pitch; -1: none
};

std::string get_name(EquationKind kind);         // "balance"
std::string get_text(const Equation& equation);  // "balance, force z"

}  // namespace hrp::diagnosis::floating
