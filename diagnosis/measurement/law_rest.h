// SPDX-License-Identifier: BSD-3-Clause
// What the servo's law misses of a joint's effort log. It does not depend on the dynamics, so what it has over the
// position is a fault of the log, and no torque on the joint.
#pragma once

#include "diagnosis/measurement/servo_law.h"

namespace hrp::diagnosis {

// Training samples where the drive is not at its limit.
struct LawRest {
  std::vector<double> position;  // [rad]
  std::vector<double> torque;    // [N m] log - (scale x law + bias)
  std::vector<size_t> recording;
  double spread = 0.0;  // [N m] of the log
  // True if the log follows the servo's law but for `part` of the rest [N m] and noise.
  bool follows_but_for(const Eigen::VectorXd& part) const;
};

// Empty without commands or a log. `late`: the joint's delays of commands are among them.
LawRest list_law_rest(const Experiment& experiment, int joint, const std::vector<ServoDelay>& late);

}  // namespace hrp::diagnosis
