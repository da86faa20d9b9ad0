// SPDX-License-Identifier: BSD-3-Clause
// A wrong mass beside friction that grows with the load, at the one joint that carries the link, and the gear that is the
// likelier cause of both.
//
// A link of mass factor s behind a gear that loses the share mu of its load takes s (1 + mu) of the nominal torque to lift
// and s (1 - mu) to lower. So does the nominal link behind a gear that loses the share r = 2 mu / (1 + mu) of the load
// only while the load drives it, with the torque constant's factor k = 1 / (s (1 + mu)). No slow motion tells them apart;
// what is known beforehand does: masses are weighed.
#pragma once

#include "diagnosis/evidence/torque_grade.h"

namespace hrp::diagnosis {

// Share of the load, of 1 [-].
double calc_backward_loss(double mu);
// The other way round: mu of a loss r, and its slope over r.
double calc_loaded_friction(double loss);
double calc_loaded_friction_slope(double loss);

// Of a wrong mass: load-dependent friction of the one joint that carries the link; null where there is none.
GradedTerm* find_gear(const TorqueDesign& design, const GradedTerm& mass, std::vector<GradedTerm>* graded);

// Friction beside a wrong mass becomes a share of the load that there is. Where the gear, with its torque constant, is the
// likelier explanation it takes the place of both, with the mass as its rival.
void explain_by_gears(const TorqueDesign& design, std::vector<GradedTerm>* graded);

}  // namespace hrp::diagnosis
