// SPDX-License-Identifier: BSD-3-Clause
// Loops of the description in the scenario that servers read, and a start pose in which all chains are closed.
#pragma once

#include <vector>

#include "common/robot/robot_description.h"
#include "servers/model_parser/loop_scan.h"

namespace hrp {

// Adds the description's loops to robot->scenario. They stand beside the scenario's own; a name in both is an error.
// Adds errors to `diagnostics`.
void merge_loops(const std::vector<LoopScan>& loops, const Scenario& scenario, const std::string& urdf_path,
                 RobotDescription* robot, Diagnostics* diagnostics);

// Moves passive joints that initial.joints does not place until all loops are closed, and writes the pose into
// robot->scenario. A loop that stays open by more than kOpenLoop is an error: where it stands, by how much, what to do.
void close_start_pose(const std::vector<LoopScan>& loops, const Scenario& scenario, RobotDescription* robot,
                      Diagnostics* diagnostics);

}  // namespace hrp
