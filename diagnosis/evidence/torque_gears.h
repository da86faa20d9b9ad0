// SPDX-License-Identifier: BSD-3-Clause
// Explains a wrong mass together with load-dependent friction, at the only joint that carries the link, by a likelier
// cause: a gear that is hard to drive backwards.
//
// A link with the mass factor s behind a gear that loses the share mu of its load needs s (1 + mu) times the nominal
// torque to lift and s (1 - mu) to lower. The nominal link needs the same torques behind a gear that loses the share r
// = 2 mu / (1 + mu) only while the load drives it, with the torque constant's factor k = 1 / (s (1 + mu)). Slow motions
// cannot distinguish the two. The prior can: masses are weighed, so they are seldom wrong.
#pragma once

#include "diagnosis/evidence/torque_grade.h"

namespace hrp::diagnosis {

// Loss r [1] of a gear that the load drives, from load-dependent friction mu [1].
double calc_backward_loss(double mu);
// Inverse: mu of a loss r, and its derivative d mu / d r.
double calc_loaded_friction(double loss);
double calc_loaded_friction_slope(double loss);

// Load-dependent friction of the only joint that carries the link of `mass`; null if there is none or `mass` is no
// wrong mass.
GradedTerm* find_gear(const TorqueDesign& design, const GradedTerm& mass, std::vector<GradedTerm>* graded);

// Converts friction beside a wrong mass to a share of the true load. If the gear together with its torque constant has
// the lower prior cost, it replaces both terms. The mass is then listed as its rival.
void explain_by_gears(const TorqueDesign& design, std::vector<GradedTerm>* graded);

}  // namespace hrp::diagnosis
