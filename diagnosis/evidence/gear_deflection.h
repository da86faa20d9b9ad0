// SPDX-License-Identifier: BSD-3-Clause
// Two encoders at one joint: how far the gear gives under the torque that it passes on.
//
//   q_motor - q_link = zero + tau / k - (d / k) rate + (g / 2) sign(tau)
//
// tau: the joint's torque sensor, else inverse dynamics of the links beyond; rate: of the deflection; sign: smooth over a
// twentieth of the torque's spread, as teeth change sides there. k, d: joint_elasticity; g: backlash; zero: of the encoders.
#pragma once

#include "diagnosis/findings/finding.h"
#include "diagnosis/measurement/link_sensors.h"
#include "diagnosis/model/effect.h"

namespace hrp::diagnosis {

struct GearVerdict {
  int joint = 0;
  std::vector<Finding> findings;
  double zero = 0.0, zero_std = 0.0;    // [rad] motor encoder less link encoder, without torque
  bool one_sided = false;               // the torque keeps its sign: half of a gap looks like a zero
  bool zero_found = false, mismatch = false, to_noise = false;
  Remaining remaining;                  // [rad] of the deflection
  SignalFit fit;
};

// Of every joint with a second encoder. `known`: effects of links that are certain.
std::vector<GearVerdict> judge_gears(const Experiment& experiment, const TorqueData& motion, const LinkSensors& sensors,
                                     const std::vector<Effect>& known);

}  // namespace hrp::diagnosis
