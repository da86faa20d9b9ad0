// SPDX-License-Identifier: BSD-3-Clause
// Motions for robots with many effects, such as friction and a rotor in every joint, and for robots that are driven by
// efforts. Explanations are compared as linear terms of the missing torque (torque_rows.h). A motion is simulated once
// under the report's model; only chosen ones are simulated further, for safety.
#pragma once

#include "diagnosis/next/propose.h"

namespace hrp::diagnosis {

Next propose_by_torque(const Experiment& experiment, const Json& report, const NextOptions& options,
                       const Progress& progress);

}  // namespace hrp::diagnosis
