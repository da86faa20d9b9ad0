// SPDX-License-Identifier: BSD-3-Clause
// Sensors on the link's side of the gears, as an experiment declares them under `sensors`:
//
//   joint_torque: [shoulder, elbow]   columns /joint_states_link/<joint>/effort [N m]
//   link_encoder: [elbow]             columns /joint_states_link/<joint>/position [rad]
#pragma once

#include <string>
#include <vector>

namespace hrp {

struct DeclaredJoint {
  std::string joint;
  int line = 0, column = 0;  // in the experiment
};

struct LinkSensorKeys {
  std::vector<DeclaredJoint> joint_torque, link_encoder;
};

// From the text of an experiment file. Throws InputError with file, line, column.
LinkSensorKeys parse_link_sensor_keys(const std::string& text, const std::string& path);

}  // namespace hrp
