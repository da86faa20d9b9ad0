// SPDX-License-Identifier: BSD-3-Clause
// Two encoders at one joint: estimates the deflection of the gear under the torque that it transmits.
//
//   q_motor - q_link = zero + tau / k - (d / k) rate + (g / 2) sign(tau)
//
// tau: the joint's torque sensor, else inverse dynamics of the links beyond the gear. rate: time derivative of the
// deflection. sign: tanh(tau / (0.05 x spread of tau)), because the teeth change sides at small torques. k, d:
// `joint_elasticity`; g: `backlash`; zero: offset of the encoders.
#pragma once

#include "diagnosis/findings/finding.h"
#include "diagnosis/measurement/link_sensors.h"
#include "diagnosis/model/effect.h"

namespace hrp::diagnosis {

// What the two encoders of one joint show: findings, the zero, and how much of the deflection they explain.
struct GearVerdict {
  int joint = 0;
  std::vector<Finding> findings;
  double zero = 0.0, zero_std = 0.0;  // [rad] motor encoder minus link encoder at zero torque
  bool one_sided = false;             // the torque keeps its sign, so half a gap looks like a zero
  bool zero_found = false, mismatch = false, to_noise = false;
  Remaining remaining;  // [rad] of the deflection
  SignalFit fit;
};

// Judges every joint that has a second encoder. `known`: effects of links that other evidence found with certainty.
std::vector<GearVerdict> judge_gears(const Experiment& experiment, const TorqueData& motion, const LinkSensors& sensors,
                                     const std::vector<Effect>& known);

}  // namespace hrp::diagnosis
