// SPDX-License-Identifier: BSD-3-Clause
// sensors.camera and sensors.lidar. Private to common/robot.
#pragma once

#include "common/robot/scenario.h"
#include "common/robot/yaml_map.h"

namespace hrp {

void read_vision_sensors(YamlMap& map, SensorsSpec* sensors);

// What needs the control period: no sensor looks more often than that.
void check_look_rates(const Scenario& scenario, Diagnostics* diagnostics);

}  // namespace hrp
