// SPDX-License-Identifier: BSD-3-Clause
// The controllers that a scenario can name: hold the initial pose, or play a motion file.
#pragma once

#include <memory>

#include "controller/client.h"

namespace hrp {

// Throws InputError when the motion cannot be played on this robot.
std::unique_ptr<Controller> make_scenario_controller(const Robot& robot);

}  // namespace hrp
