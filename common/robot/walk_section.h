// SPDX-License-Identifier: BSD-3-Clause
// Reads the section `controller.walk`.
#pragma once

#include "common/robot/walk_spec.h"
#include "common/robot/yaml_map.h"

namespace hrp {

void read_walk(YamlMap& map, WalkSpec* walk);

}  // namespace hrp
