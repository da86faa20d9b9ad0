// SPDX-License-Identifier: BSD-3-Clause
// Simulation of a robot whose base stands still, from a recording's own commands (or efforts), at its time stamps.
//
// Integrator: ROS2 (Verwer, Spee, Blom, Hundsdorfer, SIAM J. Sci. Comput. 20, 1999), a Rosenbrock method of order 2
// that stays of order 2 with any approximate Jacobian and is L-stable with gamma = 1 - 1/sqrt(2): servo, transmission
// and friction terms are implicit, so that the light wrist of an arm with stiff gains needs no smaller steps than its
// shoulder. Dry friction is bristles that bend before they slip.
//
// A drive at its limit, or one that is given efforts, does not hold the joint near a reference: the smallest error of a
// model then grows without bound. There the simulated joint is drawn to the recorded motion, softly: a pull as stiff as
// the servo's would hide what the limit does, and carry the smoothing's errors of a sharp motion into the prediction.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "diagnosis/simulation/bodies.h"
#include "diagnosis/simulation/plant.h"
#include "diagnosis/data/smooth.h"

namespace hrp::diagnosis {

constexpr double kFollow = 8.0;  // [rad/s] natural frequency, critically damped

// Integration steps times joints: what simulations cost, whatever the machine.
using Work = std::atomic<long>;

struct RolloutOptions {
  double max_step = 0.0005;    // [s]
  double until = 0.0;          // [s] stop after this long; 0: at the recording's end
  bool free_running = false;   // nothing draws a joint to its recorded motion: for short windows
  std::shared_ptr<Work> work;  // to which a rollout adds its own, where there is one
};

// Corrections of the state that a rollout begins with, by joint; empty: none. `q`, `v` are the encoder's side,
// `link_q`, `link_v` where the link is beyond an elastic transmission; `bristles` how far those of dry friction are
// bent, in pre-sliding displacements; `memory` the state of hysteresis, in its largest values.
struct StartState {
  std::vector<double> q, v, link_q, link_v, bristles, memory;
};

// Readings [sample][joint][quantity], flat. False when the motion left the finite numbers.
bool simulate_recording(const Plant& plant, const Recording& recording, const SmoothRecording& smooth,
                        const RolloutOptions& options, std::vector<double>* readings,
                        const StartState* start = nullptr);

// One joint alone, all others as they were recorded (`path`). Fills the joint's columns of readings, which must have
// their size already; sensor faults are not applied. With `links`, the motion of the joint's link goes there.
bool simulate_joint(const Plant& plant, const Recording& recording, const SmoothRecording& smooth,
                    const RobotPath& path, int joint, const RolloutOptions& options, std::vector<double>* readings,
                    std::vector<LinkMotion>* links = nullptr);

// Faults of the joints' own sensors act on what would have been read.
void apply_faults(const Plant& plant, const Recording& recording, std::vector<double>* readings);

}  // namespace hrp::diagnosis
