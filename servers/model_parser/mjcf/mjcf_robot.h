// SPDX-License-Identifier: BSD-3-Clause
// A robot in MJCF, MuJoCo's format, as MuJoCo's own compiler understands it: classes, includes and inertias of geometry
// are resolved there.
#pragma once

#include <string>

#include "common/base/diagnostics.h"
#include "servers/model_parser/body_tree.h"

namespace hrp {

// Adds to `diagnostics` what is wrong and what this simulator does not hold: tendons, equality constraints other than a
// joint that follows a joint linearly, ball joints, several free bodies, ellipsoids and planes that touch. Warns of
// what is the scenario's in its place: geometry of the world, servo gains.
BodyTree read_mjcf(const std::string& text, const std::string& path, bool floating_base, Diagnostics* diagnostics);

}  // namespace hrp
