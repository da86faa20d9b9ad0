// SPDX-License-Identifier: BSD-3-Clause
// Terms that fit the training recordings and mislead on others: another model is the better one there.
#pragma once

#include "diagnosis/evidence/torque_model.h"

namespace hrp::diagnosis {

// Joint by joint, chooses again without the row of terms with which held-out recordings are predicted worse, as long as
// that helps there. No parameter is fitted to them. Nothing happens without held-out recordings.
void drop_misleading_terms(int jobs, Timing timing, TorqueDesign* design, Choice* choice);

}  // namespace hrp::diagnosis
