// SPDX-License-Identifier: BSD-3-Clause
// The model that was found, for other simulators: MJCF, URDF, SDF, and a table for Isaac Lab's actuator models. Every
// file says in comments what its format cannot hold (docs/export.md).
#pragma once

#include <string>
#include <vector>

#include "common/effects/joint_law.h"
#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"

namespace hrp::diagnosis {

struct TakeHome {
  Scenario scenario;                // the updated one
  RobotDescription robot;           // effects of links are in its tree, rotors in its joints
  std::vector<JointLaws> laws;      // by joint, with what was found
  std::vector<std::string> forces;  // constant forces, and soles on rubber, in words
};

// From DIR/updated/scenario.yaml; soles on rubber are left out. Throws InputError.
TakeHome load_take_home(const std::string& scenario_path);

// The formats differ in what they hold.
std::string make_mjcf_model(const TakeHome& model);
std::string make_urdf_model(const TakeHome& model);
std::string make_sdf_model(const TakeHome& model);
std::string make_isaac_table(const TakeHome& model);

// A scenario beside robot.urdf for hrp-dynamics-mujoco: `nominal` (a scenario's text) with what both hold.
std::string make_mujoco_scenario(const TakeHome& model, const std::string& nominal);

// DIR/updated/export/: robot.xml, robot.urdf, robot.sdf, isaac_lab.yaml, mujoco.yaml. Throws std::runtime_error.
void write_take_home(const std::string& updated_folder);

}  // namespace hrp::diagnosis
