// SPDX-License-Identifier: BSD-3-Clause
// Plain linear least squares of viscous friction, Coulomb friction and rotor inertia at every driven joint, as a simple
// form of the inverse dynamic identification by Gautier and Khalil. It is the reference that the tool's own model must
// not be worse than.
#pragma once

#include <vector>

#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {

// Parameters of a joint's drive. None is negative.
struct PlainDrive {
  double viscous = 0.0;  // [N m s/rad]
  double dry = 0.0;      // [N m]
  double rotor = 0.0;    // [kg m^2]
  double gear = 0.0;     // backdriving_friction: share [1] of a load that the gear holds while this load drives it
};

// By joint. `with_gears` also fits `gear`.
std::vector<PlainDrive> fit_plain_model(const Problem& problem, bool with_gears = false);

constexpr double kStick = 0.002;  // [rad] of displacement before friction slips

// The fitted drives as effects of a simulation.
Hypothesis make_plain_model(const std::vector<PlainDrive>& fitted);

}  // namespace hrp::diagnosis
