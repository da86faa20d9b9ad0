// SPDX-License-Identifier: BSD-3-Clause
// Explains a wrong mass together with load-dependent friction, at the only joint that carries the link, by a likelier
// cause: a gear that is hard to drive backwards.
//
// A link with the mass factor s needs these multiples of the nominal torque:
//
//   friction                             to lift       to lower        Term::shape
//   share mu of the bodies' torque       s (1 + mu)    s (1 - mu)      kLoadOfBodies
//   share mu of the drive's effort       s / (1 - mu)  s / (1 + mu)    kLoadOfDrive
//
// The nominal link needs 1 / k to lift and (1 - r) / k to lower behind a gear that loses the share r only while the
// load drives it; k is the torque constant's factor. In both rows r = 2 mu / (1 + mu) gives the same torques. Slow
// motions cannot distinguish the explanations. The prior can: masses are weighed, so they are seldom wrong.
#pragma once

#include "diagnosis/evidence/torque/grade.h"

namespace hrp::diagnosis {

// Loss r [1] of a gear that the load drives, from load-dependent friction mu [1].
double calc_backward_loss(double mu);
// Factor k [1] of the torque constant beside the gear that replaces `mass` and `friction`.
double calc_gear_gain(const GradedTerm& mass, const GradedTerm& friction);
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
