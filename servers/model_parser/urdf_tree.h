// SPDX-License-Identifier: BSD-3-Clause
// urdfdom's model -> tree of moving links, fixed joints lumped. The only folder that includes urdfdom.
#pragma once

#include "common/base/diagnostics.h"
#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"
#include "servers/model_parser/urdf_scan.h"

namespace hrp {

// Fills tree and shapes. What is wrong goes to `diagnostics`, with file and line; warnings, too.
void build_tree(const UrdfScan& scan, const Scenario& scenario, RobotDescription* robot, Diagnostics* diagnostics);

}  // namespace hrp
