// SPDX-License-Identifier: BSD-3-Clause
// The robot as its description and the experiment state it, effects under `effects`, `joint_laws` and `link_laws`
// included: what every engine starts from. What is stated is simulated, so it is not found again and added twice.
#pragma once

#include <vector>

#include "common/effects/joint_law.h"
#include "common/multibody/tree_spec.h"
#include "diagnosis/data/recording.h"
#include "servers/dynamics/link_effects.h"

namespace hrp::diagnosis {

struct NominalRobot {
  TreeSpec tree;                  // rotors of the description are in it
  std::vector<JointLaws> laws;    // by joint; motor_inertia is what effects add
  std::vector<Vector3d> force_W;  // [N] by link at its centre of mass; empty: none
};

// Recorded efforts drive the joints, no servo.
bool is_effort_driven(const Experiment& experiment);

// Effects of places that the robot does not have are refused when the experiment is read.
NominalRobot make_nominal(const Experiment& experiment);

// What hung on the robot in one recording, and what pulled at it. A tree that does not have the link carries nothing.
void add_loads(const RecordingSpec& recording, TreeSpec* tree);
std::vector<SteadyForce> list_pulls(const RecordingSpec& recording, const TreeSpec& tree);

}  // namespace hrp::diagnosis
