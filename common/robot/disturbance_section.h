// SPDX-License-Identifier: BSD-3-Clause
// What acts on a robot from outside, and how it differs from its description: variation, pushes, hands. Private to
// common/robot.
#pragma once

#include "common/robot/scenario.h"
#include "common/robot/yaml_map.h"

namespace hrp {

void read_disturbance_sections(YamlMap& map, Scenario* scenario);

}  // namespace hrp
