// SPDX-License-Identifier: BSD-3-Clause
// A wrong mass beside friction that grows with the load, at the one joint that carries the link, and the gear that is the
// likelier cause of both.
//
// A link of mass factor s takes a share of the nominal torque to lift and another to lower:
//
//   friction mu of the bodies' torque    s (1 + mu)    s (1 - mu)      Term::shape kLoadOfBodies
//   friction mu of the drive's effort    s / (1 - mu)  s / (1 + mu)    kLoadOfDrive
//
// The nominal link behind a gear takes 1 / k to lift and (1 - r) / k to lower, if the gear loses the share r of the load
// only while the load drives it, and k is the torque constant's factor. In both cases r = 2 mu / (1 + mu) is the same gear.
// No slow motion tells them apart; what is known beforehand does: masses are weighed.
#pragma once

#include "diagnosis/evidence/torque_grade.h"

namespace hrp::diagnosis {

// Share of the load, of 1 [-].
double calc_backward_loss(double mu);
// Factor k of the torque constant beside such a gear.
double calc_gear_gain(const GradedTerm& mass, const GradedTerm& friction);
// The other way round: mu of a loss r, and its slope over r.
double calc_loaded_friction(double loss);
double calc_loaded_friction_slope(double loss);

// Of a wrong mass: load-dependent friction of the one joint that carries the link; null where there is none.
GradedTerm* find_gear(const TorqueDesign& design, const GradedTerm& mass, std::vector<GradedTerm>* graded);

// Where the gear, with its torque constant, is the likelier explanation it takes the place of the mass and of the friction,
// with the mass as its rival.
void explain_by_gears(const TorqueDesign& design, std::vector<GradedTerm>* graded);

}  // namespace hrp::diagnosis
