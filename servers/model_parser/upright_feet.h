// SPDX-License-Identifier: BSD-3-Clause
// Feet whose axes in the robot's file do not have z up: links from CAD, or with axes by Denavit and Hartenberg.
#pragma once

#include <map>
#include <string>

#include "common/robot/scenario.h"
#include "servers/model_parser/urdf_model.h"

namespace hrp {

// R_CL of moving links that are feet, by their names: C has the axes of the URDF, L those of the foot with z up. A turn
// about an axis by quarters, so that a sole keeps its sides. Only feet that need one. Up is the base's z axis in the
// initial pose.
std::map<std::string, Matrix3d> find_upright_feet(const urdf::ModelInterface& model, const UrdfScan& scan,
                                                  const Scenario& scenario);

}  // namespace hrp
