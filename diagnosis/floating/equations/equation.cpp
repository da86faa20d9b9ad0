// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/equations/equation.h"

#include "common/base/check.h"

namespace hrp::diagnosis::floating {

std::string get_name(EquationKind kind) {
  switch (kind) {
    case EquationKind::kMoment:
    case EquationKind::kForce: return "balance";
    case EquationKind::kLegMoment:
    case EquationKind::kLegForce: return "balance by legs";
    case EquationKind::kWeight: return "weight";
    case EquationKind::kJoint: return "joint";
    case EquationKind::kServo: return "servo";
    case EquationKind::kGyroscope:
    case EquationKind::kGyroscopeOverFeet: return "gyroscope";
    case EquationKind::kAccelerometer: return "accelerometer";
    case EquationKind::kGravity: return "gravity";
    case EquationKind::kTilt: return "tilt";
    case EquationKind::kHeight: return "height";
  }
  HRP_CHECK(false, "an equation has a kind");
  return "";
}

std::string get_text(const Equation& e) {
  std::string name = get_name(e.kind);
  if (e.axis < 0) return name;
  if (e.is(EquationKind::kTilt)) return name + (e.axis == 0 ? ", roll" : ", pitch");
  const char axis = "xyz"[e.axis];
  if (e.is(EquationKind::kMoment) || e.is(EquationKind::kLegMoment)) return name + ", moment " + axis;
  if (e.is(EquationKind::kForce) || e.is(EquationKind::kLegForce)) return name + ", force " + axis;
  if (e.is(EquationKind::kGyroscopeOverFeet)) return name + " over standing feet, " + axis;
  return name + ' ' + axis;
}

}  // namespace hrp::diagnosis::floating
