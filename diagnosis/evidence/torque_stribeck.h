// SPDX-License-Identifier: BSD-3-Clause
// Dry friction that is larger at rest: how far the recordings tell its curve, by the profile of its likelihood over the
// velocity at which the excess is gone.
#pragma once

#include "diagnosis/evidence/torque_model.h"

namespace hrp::diagnosis {

struct Range {
  double value = 0.0, low = 0.0, high = 0.0;  // best; 95 %
};

// Friction = level + excess exp(-(v / velocity)^2), against the motion.
struct DryCurve {
  bool there = false;  // else the joint's model has no level of dry friction
  Range velocity, level, rest;  // [rad/s], [N m], [N m]: level + excess
  double gain = 0.0;   // [nats] of the curve over the level alone
};

DryCurve profile_dry_curve(const TorqueDesign& design, const TorqueModel& model, size_t joint);

}  // namespace hrp::diagnosis
