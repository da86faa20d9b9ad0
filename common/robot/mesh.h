// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/robot/surface.h"

namespace hrp {

// Reads a mesh file with the matrices of its nodes (a .dae may hide a scale there), then scales it. The up axis that a
// file declares is not applied, as ROS tools do. Throws InputError naming the file.
Mesh load_mesh(const std::string& path, const Vector3d& scale);

}  // namespace hrp
