// SPDX-License-Identifier: BSD-3-Clause
// A robot in SDF, Gazebo's format, as libsdformat reads it: frames and poses are resolved there.
#pragma once

#include <string>

#include "common/base/diagnostics.h"
#include "servers/model_parser/body_tree.h"

namespace hrp {

// Adds to `diagnostics` what is wrong and what this simulator does not hold: worlds, nested models, joints other than
// revolute, continuous, prismatic and fixed, closed chains, shapes other than box, sphere, cylinder, capsule and mesh.
BodyTree read_sdf(const std::string& text, const std::string& path, bool floating_base, Diagnostics* diagnostics);

}  // namespace hrp
