// SPDX-License-Identifier: BSD-3-Clause
// What other identification programs would answer. They fit a model that the user chooses to simulated motion. Here
// their models are written with effects of the table, simulated by this tool, and fitted to the recorded positions.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {

// Parameters of every driven joint.
struct OtherAnswer {
  std::string model;
  Hypothesis hypothesis;
};

// Friction models of increasing size, each in all driven joints at once, with a rotor. The fits start from plain least
// squares.
//   - M1 to M5 are those of BAM [D24]: Coulomb and viscous, Stribeck, growing with the load, both, with a direction of
//     the load. M6 is quadratic in the load, for which the table has no effect.
//   - M1 is also the answer of programs that fit the parameters which the user ticks, if these are damping, friction
//     loss and armature: `mujoco.sysid` (SO-101 example of MuJoCo Playground), and the System Identification extension
//     of Isaac Sim 6.2.
std::vector<OtherAnswer> fit_friction_models(const Problem& problem);

}  // namespace hrp::diagnosis
