// SPDX-License-Identifier: BSD-3-Clause
// Standing robots whose every drive has losses, as real ones do. One effect after the other would be added for hours.
// Instead
//   - each joint is judged by its missing torque alone (evidence/torque_findings.h),
//   - links, feet and sensors by the equations in which no drive has a part: balance, tilt, places, gyroscope.
#pragma once

#include "diagnosis/evidence/torque_findings.h"
#include "diagnosis/report/report.h"
#include "diagnosis/standing/fit.h"

namespace hrp::diagnosis::standing {

using Progress = std::function<void(const std::string&)>;

// False where the drives of most joints are as stated. `problems` as diagnose_standing() prepares them.
bool diagnose_many_drives(const StandProblems& problems, int jobs, const Progress& progress, Reports* out);

}  // namespace hrp::diagnosis::standing
