// SPDX-License-Identifier: BSD-3-Clause
// One cause in place of several terms of the whole robot: drives that give less than they say leave a share of the
// weight that they carry, as a force that lifts a link or lighter links do. A load in the hand moves the centres of
// mass of its link and of the links before it.
#pragma once

#include "diagnosis/evidence/torque/rivals.h"

namespace hrp::diagnosis {

constexpr double kSame = 1.0;  // [nats] of likelihood within which two models are indistinguishable

// The gains of all drives that carry a term, in its place or in that of all wrong masses, and loads in place of several
// wrong masses. No joint's error counts below the share to which efforts and masses are known. `g`: the graded term.
std::vector<Rival> list_common_causes(const TorqueDesign& design, const Gap& gap, const GradedTerm& g);

// True if a term of the whole robot has a nonzero column in the joint's rows.
bool is_shown(const TorqueDesign& design, const Term& whole, const JointDesign& joint);

}  // namespace hrp::diagnosis
