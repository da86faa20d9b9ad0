// SPDX-License-Identifier: BSD-3-Clause
// Robots on a rail or stand whose feet touch the ground or are held, with the measured force on them: each joint by its
// missing torque (measurement/torque/torque.h), what gives by the foot's height (foot_give.h). Nothing is simulated.
#pragma once

#include <functional>
#include <string>

#include "diagnosis/report/report.h"

namespace hrp::diagnosis::held_feet {

// False when these recordings are not that, with the reason.
bool diagnose_held_feet(const Experiment& experiment, int jobs, const std::function<void(const std::string&)>& progress,
                        Reports* reports, std::string* why);

}  // namespace hrp::diagnosis::held_feet
