// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/robot/scenario.h"

namespace hrp::diagnosis {

// Those of the joint's own drive, or of all drives that have none of their own.
inline const ServoGains& get_servo_gains(const Scenario& scenario, const std::string& joint) {
  const auto own = scenario.servo_joints.find(joint);
  return own == scenario.servo_joints.end() ? scenario.servo_default : own->second;
}

}  // namespace hrp::diagnosis
