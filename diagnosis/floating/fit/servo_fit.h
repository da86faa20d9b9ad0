// SPDX-License-Identifier: BSD-3-Clause
// Joints that were taken to follow their commands exactly, and do not: the servo that moves them, from what it was
// asked for, what the joint did and what effort it gave.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "diagnosis/data/recording.h"
#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis::floating {

// effort = kp (command - position) + kd (command's rate - velocity); SI.
struct ServoFit {
  double kp = 0, kd = 0, kp_std = 0, kd_std = 0;
  double share = 0;  // of the held-out effort's mean square that the law gives
  bool found = false;
};

// One sample of the law: (position error, velocity error) and effort.
struct ServoSamples {
  std::vector<Eigen::Vector2d> error;
  std::vector<double> effort;
};

// Instrumental variables: the neighbours' errors stand in for each sample's own, whose noise would flatten the law.
// `train` and `held` by recording.
ServoFit fit_servo(const std::vector<ServoSamples>& train, const std::vector<ServoSamples>& held);

// A finding `joint_servo` for each joint that moves by such a law; none unless the scenario has perfect joints.
std::vector<Finding> find_servos(const Experiment& experiment);

}  // namespace hrp::diagnosis::floating
