// SPDX-License-Identifier: BSD-3-Clause
// Finds other terms that fit equally well in the place of a term.
#pragma once

#include "diagnosis/evidence/torque/grade.h"

namespace hrp::diagnosis {

// A model, the same model without the term in question, and the fits of both.
struct Gap {
  const TorqueModel& model;
  const TorqueFit& fit;
  const TorqueModel& rest;
  const TorqueFit& alone;
};

// `judge`: the joint of the design whose rows show most of the term. The caller fills in the widths of rivals that have
// a model.
std::vector<Rival> list_rivals(const TorqueDesign& design, const Gap& gap, size_t judge, const GradedTerm& g);

// [kg m^2] Inertia of the link that a joint turns, about its centre of mass and the joint's axis.
double calc_own_inertia(const TreeSpec& tree, int joint);

bool is_rotor(const Term& term);
bool is_viscous(const Term& term);

}  // namespace hrp::diagnosis
