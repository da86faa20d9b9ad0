// SPDX-License-Identifier: BSD-3-Clause
// The sections of a scenario file. Private to common/robot.
#pragma once

#include "common/robot/scenario.h"
#include "common/robot/yaml_map.h"

namespace hrp {

// ground, feet, soles, contact, foot_bush, obstacles, self_collision, no_contact.
void read_world_sections(YamlMap& map, Scenario* scenario);

// servo, perfect_joints, unactuated, rotor_inertia, initial, joint_laws, controller.
void read_joint_sections(YamlMap& map, Scenario* scenario);

// sensors, logging.
void read_sensor_sections(YamlMap& map, Scenario* scenario);

}  // namespace hrp
