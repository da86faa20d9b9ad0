// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/effects/world_spec.h"

namespace hrp {

// MuJoCo's constants of a contact point. MuJoCo asks each point for the acceleration a_ref = -b v - k r, with r the
// distance and v its rate, and lets it have a = a_ref - R f, with f the force and R = (1 - d) / d / m. So the point is
// a spring k / R beside a damper b / R, and it carries a mass 1 / R along while it touches (MuJoCo documentation,
// "Computation", "Constraint model").
struct GroundLaw {
  double impedance = 0.9;  // d
  double k = 0.0;          // [1/s^2]
  double b = 0.0;          // [1/s]
};

// The straight line through equation (3) of [H03] at the depth where the point carries `load`.
// load [N]; mass [kg]: the link's own at the point, as MuJoCo has it at the start; time_step [s].
GroundLaw calc_ground_law(const ContactSpec& contact, double load, double mass, double time_step);

}  // namespace hrp
