// SPDX-License-Identifier: BSD-3-Clause
// What poses tell without a law of contact: how bodies fall, how high they rest, and how a struck corner turns them.
#pragma once

#include "diagnosis/toss/data.h"

namespace hrp::diagnosis::toss {

// One point strikes between two free flights: all impulse acts there, whatever the law of contact.
struct Strike {
  size_t toss = 0;
  Vector3d p_BcmC_W{0, 0, 0};  // [m] from the centre of mass to the point that strikes
  Vector3d dv_WBcm{0, 0, 0};   // [m/s] change of the centre of mass' velocity
  Vector3d dw_WB{0, 0, 0};     // [rad/s]
  Matrix3d I_BBcm_W = Matrix3d::Zero();  // [kg m^2] of the model, as the body lies
};
std::vector<Strike> find_strikes(const TossProblem& problem);

// Acceleration of free fall over the model's gravity. Empty below eight stretches of flight.
std::optional<Measured> measure_fall(const TossProblem& problem);

// Moments of inertia over the model's, by p_BcmC x m dv = scale I dw. Empty below eight strikes.
std::optional<Measured> measure_inertia(const TossProblem& problem);

// [m] Height of the plane that bodies at rest lie on, over the model's ground. Empty below four such tosses.
std::optional<Measured> measure_rest_height(const TossProblem& problem);

}  // namespace hrp::diagnosis::toss
