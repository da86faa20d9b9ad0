// SPDX-License-Identifier: BSD-3-Clause
// An SDF world as obstacles and ground of a scenario.
#pragma once

#include "common/base/diagnostics.h"
#include "common/robot/world_text.h"

namespace hrp {

// Reads scenario.world. Static models become obstacles, named after them, and a plane becomes the ground; without a
// plane there is none. Models that are not static, shapes other than box, sphere, cylinder, capsule, mesh and plane, a
// second plane, and meshes that are not there are errors.
WorldSpec read_sdf_world(const std::string& text, const Scenario& scenario, Diagnostics* diagnostics);

// Roll, then pitch about world axes that turn the z axis to `n` (unit, z > 0), as GroundSpec has them [rad].
void set_ground_normal(const Vector3d& n, GroundSpec* ground);

}  // namespace hrp
