// SPDX-License-Identifier: BSD-3-Clause
// Stribeck friction: confidence ranges of its curve, from the profile likelihood over the Stribeck velocity.
#pragma once

#include "diagnosis/evidence/torque/model.h"

namespace hrp::diagnosis {

struct Range {
  double value = 0.0, low = 0.0, high = 0.0;  // best value; 95 % range
};

// Friction torque = level + excess exp(-(v / velocity)^2), against the motion.
struct DryCurve {
  bool there = false;           // if false, the joint's model has no level of dry friction
  Range velocity, level, rest;  // [rad/s], [N m], [N m]: rest = level + excess
  double gain = 0.0;            // [nats] log-likelihood of the curve over a constant level
};

// Profiles the curve of a joint (index in the design) over Stribeck velocities between 1 and 50 % of the fastest speed.
DryCurve profile_dry_curve(const TorqueDesign& design, const TorqueModel& model, size_t joint);

}  // namespace hrp::diagnosis
