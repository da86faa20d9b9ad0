// SPDX-License-Identifier: BSD-3-Clause
// Physics outside the tool's list: the right answer is that something is missing, where, and on what it depends.
#pragma once

#include "diagnosis/generator/hidden.h"

namespace hrp::cases {

Hidden draw_unlisted_of_joint(const std::string& effect, const RobotPlan& robot, const JointPlan& joint, double boost,
                              Prng& random);

// `sprung_mass` (part of a link's mass hangs on a spring) and `gust` (a force on the trunk that comes and goes).
Hidden draw_unlisted_of_body(const std::string& effect, const RobotPlan& robot, double boost, Prng& random);

}  // namespace hrp::cases
