// SPDX-License-Identifier: BSD-3-Clause
// Finds torque ripple over a joint's position in its missing torque, and ripple of the log of its effort.
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

// Wave numbers [1/rad] of the highest peaks in the periodogram of the missing torque over the position, highest first,
// at most three. Training samples, beside friction, rotor, load and a constant. Ripples with less than one and a half
// periods within the joint's travel look like a spring or gravity, and the filter removes those that pass faster than
// the cutoff; both are left out. Parts of the recordings must agree about the phase. Empty if no peak is significant.
std::vector<double> find_ripples(const TorqueData& data, int joint);

// a cos(N q) + b sin(N q) that the log of an effort has beside the torque [N m].
struct LogRipple {
  double periods = 0.0;                                 // N [1/rad]
  Eigen::Vector2d amplitude = Eigen::Vector2d::Zero();  // a, b [N m]
  double mean = 0.0;                                    // [N m] over the log
  Eigen::VectorXd calc(const Eigen::VectorXd& q) const {
    return amplitude[0] * (periods * q.array()).cos() + amplitude[1] * (periods * q.array()).sin();
  }
};

// The one that takes most of what the log has beside the servo's law, at least a quarter, if the missing torque has the
// same.
std::optional<LogRipple> find_log_ripple(const TorqueData& data, int joint);

}  // namespace hrp::diagnosis
