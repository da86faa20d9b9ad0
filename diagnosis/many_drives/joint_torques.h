// SPDX-License-Identifier: BSD-3-Clause
// The missing torque of a standing robot's joints (measurement/torque.h): the base's motion is the IMU's, and what feet
// feel is on the links. Nothing is simulated and no joint's error reaches another.
#pragma once

#include "diagnosis/measurement/torque.h"
#include "diagnosis/standing/terms.h"

namespace hrp::diagnosis::standing {

// Along the recorded motion, with what a hypothesis says of links, sensors and zeros of encoders. Effects of drives in
// it say nothing here.
TorqueData make_joint_torques(const StandProblem& problem, const Hypothesis& hypothesis);

}  // namespace hrp::diagnosis::standing
