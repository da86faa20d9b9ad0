// SPDX-License-Identifier: BSD-3-Clause
// Removes terms that fit the training recordings but make the held-out prediction worse (overfitting).
#pragma once

#include "diagnosis/evidence/torque/grade.h"

namespace hrp::diagnosis {

// For each joint, bars the kind of term (TermRow) without which held-out recordings are predicted clearly better, and
// chooses the model again. Repeats while this helps. Held-out recordings only select; no parameter is fitted to them.
// Without held-out recordings, nothing changes.
void drop_misleading_terms(int jobs, Timing timing, TorqueDesign* design, Choice* choice);

// Where a constant torque, or another zero of a joint, predicts held-out recordings no better than nothing does,
// another zero may stand in its place: one that all recordings together make as likely, and that predicts the held-out
// ones clearly better. An arm that hangs down, for example, sees a displaced encoder zero as a constant torque;
// held-out motion far from there does not.
void exchange_misleading_zeros(const TorqueDesign& design, int jobs, Choice* choice);

// A gain scales friction, rotor and loads of its joint. If held-out recordings refuse it, the report does not say it,
// and these sizes would rest on a factor that nobody knows of. Chooses the model without such gains, unless that
// predicts held-out recordings worse. Returns true if the choice changed.
bool drop_false_gains(int jobs, const std::vector<GradedTerm>& graded, TorqueDesign* design, Choice* choice);

}  // namespace hrp::diagnosis
