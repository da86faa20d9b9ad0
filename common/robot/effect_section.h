// SPDX-License-Identifier: BSD-3-Clause
// Effects in a scenario: joint_laws, link_laws, and `effects`, a list in the form of the diagnosis tool's findings.
// Private to common/robot.
#pragma once

#include "common/robot/scenario.h"
#include "common/robot/yaml_map.h"

namespace hrp {

// To be called when feet, sensors and steps have been read.
void read_effect_sections(YamlMap& map, Scenario* scenario);

}  // namespace hrp
