// SPDX-License-Identifier: BSD-3-Clause
// What anybody would do first: plain linear least squares of viscous and Coulomb friction and rotor inertia at every driven
// joint (Gautier and Khalil's inverse dynamic identification in its simplest form). To compare with, and a model that the
// tool's own must not fall behind.
#pragma once

#include <vector>

#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {

// A joint's drive; nothing of it is negative.
struct PlainDrive {
  double viscous = 0.0;  // [N m s/rad]
  double dry = 0.0;      // [N m]
  double rotor = 0.0;    // [kg m^2]
  double gear = 0.0;     // share of the load that the gear takes while the load drives it: backdriving_friction
};

// By joint; gears only on demand: nobody would fit them first.
std::vector<PlainDrive> fit_plain_model(const Problem& problem, bool with_gears = false);

Hypothesis make_plain_model(const std::vector<PlainDrive>& fitted);

}  // namespace hrp::diagnosis
