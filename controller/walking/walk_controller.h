// SPDX-License-Identifier: BSD-3-Clause
// The walking controller: knows sensors and the robot's description, nothing else.
#pragma once

#include <memory>

#include "controller/client.h"

namespace hrp {

// Throws InputError: robots that it cannot walk with, steps that cannot be walked (the latter with the first sample).
std::unique_ptr<Controller> make_walk_controller(const Robot& robot);

}  // namespace hrp
