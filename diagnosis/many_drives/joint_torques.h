// SPDX-License-Identifier: BSD-3-Clause
// Missing torque of a standing robot's joints (measurement/torque/torque.h). The base moves as the IMU measures, and
// the feet's wrenches act on the links. No simulation is needed, and an error of one joint does not affect the others.
#pragma once

#include "diagnosis/measurement/torque/torque.h"
#include "diagnosis/standing/terms.h"

namespace hrp::diagnosis::standing {

// Missing torque along the recorded motion. The hypothesis corrects links, sensors and encoder zeros; its effects of
// drives are ignored.
TorqueData make_joint_torques(const StandProblem& problem, const Hypothesis& hypothesis);

}  // namespace hrp::diagnosis::standing
