// SPDX-License-Identifier: BSD-3-Clause
// Removes terms that fit the training recordings but make the held-out prediction worse (overfitting).
#pragma once

#include "diagnosis/evidence/torque_model.h"

namespace hrp::diagnosis {

// For each joint, bars the kind of term (TermRow) without which held-out recordings are predicted clearly better, and
// chooses the model again. Repeats while this helps. Held-out recordings only select; no parameter is fitted to them.
// Without held-out recordings, nothing changes.
void drop_misleading_terms(int jobs, Timing timing, TorqueDesign* design, Choice* choice);

}  // namespace hrp::diagnosis
