// SPDX-License-Identifier: BSD-3-Clause
// Robots on a fixed base that nothing touches: by simulation where a few effects explain everything down to the noise,
// by the missing torque along the recorded motion where every drive has losses of its own.
#pragma once

#include "diagnosis/report/report.h"

namespace hrp::diagnosis {

Reports diagnose_fixed_base(const Problem& problem, const Progress& progress);

}  // namespace hrp::diagnosis
