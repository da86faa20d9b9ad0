// SPDX-License-Identifier: BSD-3-Clause
// Friction that the model states and the recordings refute. Many URDF files carry a placeholder in <dynamics>. Effects
// add to what a model states, and none can take friction away: so what is refuted is taken out of the model first, and
// said.
#pragma once

#include <string>
#include <vector>

#include "common/effects/effect_info.h"
#include "diagnosis/report/first.h"

namespace hrp::diagnosis {

struct RefutedFriction {
  int joint = 0;
  const EffectInfo* effect = nullptr;  // dry or viscous friction: <dynamics friction> or damping
  double stated = 0.0;                 // [N m s/rad] or [N m]; of a slide [N s/m] or [N]
  double found = 0.0, std = 0.0;       // what the recordings show in its place; not below 0
  double share = 0.0;                  // of the joint's missing torque, squared, that goes away without it

  const std::string& unit() const { return effect->parameters[0].unit; }  // of a joint that turns
};

// By the missing torque, beside all that every drive has. Robots on a fixed base; empty where nothing is stated.
std::vector<RefutedFriction> find_refuted_friction(const Experiment& experiment);

// The same experiment with a model that states 0 there, in its text, too.
Experiment drop_friction(Experiment experiment, const std::vector<RefutedFriction>& refuted);

// Says each. Friction that was found at the same place since is the whole of it; where none was found, what is stated
// is the finding.
void add_refuted_friction(const Experiment& experiment, const std::vector<RefutedFriction>& refuted, Reports* reports);

}  // namespace hrp::diagnosis
