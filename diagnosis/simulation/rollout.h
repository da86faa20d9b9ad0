// SPDX-License-Identifier: BSD-3-Clause
// Simulates a robot on a fixed base from a recording's own commands (or efforts), at its time stamps.
//
// Integrator: ROS2 (Verwer, Spee, Blom, Hundsdorfer, SIAM J. Sci. Comput. 20, 1999), a Rosenbrock method of order 2. It
// keeps order 2 with any approximate Jacobian and is L-stable with gamma = 1 - 1/sqrt(2). Servo, transmission and
// friction are implicit, so the light wrist of an arm with stiff gains needs no smaller steps than its shoulder. Dry
// friction is modelled by bristles that bend before they slip.
//
// A drive at its limit, or one that receives efforts, does not hold the joint at a reference, so model errors grow
// without bound. Therefore a weak spring and damper then pull the simulated joint to the recorded motion. A pull as
// stiff as the servo would hide the effect of the limit, and would add smoothing errors of fast motion to the
// prediction.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "diagnosis/data/smooth.h"
#include "diagnosis/simulation/bodies.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {

constexpr double kFollow = 8.0;  // [rad/s] natural frequency of this pull, critically damped

// Unit of work: integration steps times joints, the same on every machine.
using Work = std::atomic<long>;

struct RolloutOptions {
  double max_step = 0.0005;    // [s]
  double until = 0.0;          // [s] duration; 0: to the end of the recording
  bool free_running = false;   // no pull to the recorded motion: for short windows
  std::shared_ptr<Work> work;  // counter that a rollout increases; null: none
};

// Corrections of a rollout's start state, by joint; empty: none. `q`, `v`: encoder side; `link_q`, `link_v`: link side
// of an elastic transmission; `bristles`: deflection of dry friction, in pre-sliding displacements; `memory`: state of
// hysteresis, relative to its largest value.
struct StartState {
  std::vector<double> q, v, link_q, link_v, bristles, memory;
};

// Readings [sample][joint][quantity], flat. Returns false if the motion becomes infinite.
bool simulate_recording(const Plant& plant, const Recording& recording, const SmoothRecording& smooth,
                        const RolloutOptions& options, std::vector<double>* readings,
                        const StartState* start = nullptr);

// One joint alone, with the others along `path`. Fills the joint's columns of `readings`, which must have their size;
// does not apply sensor faults. `links`, if given, receives the motion of the joint's link.
bool simulate_joint(const Plant& plant, const Recording& recording, const SmoothRecording& smooth,
                    const RobotPath& path, int joint, const RolloutOptions& options, std::vector<double>* readings,
                    std::vector<LinkMotion>* links = nullptr);

// Applies the faults of the joints' sensors to the readings.
void apply_faults(const Plant& plant, const Recording& recording, std::vector<double>* readings);

}  // namespace hrp::diagnosis
