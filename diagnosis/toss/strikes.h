// SPDX-License-Identifier: BSD-3-Clause
// Values from poses alone, without a law of contact: acceleration of fall, height of rest, rotation by an impact at a
// corner.
#pragma once

#include "diagnosis/toss/data.h"

namespace hrp::diagnosis::toss {

// An impact at one point between two free flights. The whole impulse acts at this point, whatever the law of contact.
struct Strike {
  size_t toss = 0;
  Vector3d p_BcmC_W{0, 0, 0};            // [m] from the centre of mass to the point of impact
  Vector3d dv_WBcm{0, 0, 0};             // [m/s] change of the velocity of the centre of mass
  Vector3d dw_WB{0, 0, 0};               // [rad/s]
  Matrix3d I_BBcm_W = Matrix3d::Zero();  // [kg m^2] of the model, in the attitude at impact
};

// All such impacts of all tosses.
std::vector<Strike> find_strikes(const TossProblem& problem);

// Acceleration of free fall relative to the model's gravity [1]. Empty with fewer than eight flights.
std::optional<Measured> measure_fall(const TossProblem& problem);

// Moments of inertia relative to the model's [1], from p_BcmC x m dv = scale I dw. Empty with fewer than eight impacts.
std::optional<Measured> measure_inertia(const TossProblem& problem);

// Height [m] of the plane that bodies at rest lie on, above the model's ground. Empty with fewer than four such tosses.
std::optional<Measured> measure_rest_height(const TossProblem& problem);

}  // namespace hrp::diagnosis::toss
