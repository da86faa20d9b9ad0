// SPDX-License-Identifier: BSD-3-Clause
// Which other terms do as well in the place of a term of a model.
#pragma once

#include "diagnosis/evidence/torque_grade.h"

namespace hrp::diagnosis {

// A model, the rest of it without the term that is asked for, and the fits of both.
struct Gap {
  const TorqueModel& model;
  const TorqueFit& fit;
  const TorqueModel& rest;
  const TorqueFit& alone;
};

// `judge`: the joint of the design whose rows say most of the term. Widths of terms with a model of their own are left to
// the caller.
std::vector<Rival> list_rivals(const TorqueDesign& design, const Gap& gap, size_t judge, const GradedTerm& g);

}  // namespace hrp::diagnosis
