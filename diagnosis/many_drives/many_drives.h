// SPDX-License-Identifier: BSD-3-Clause
// Diagnosis of standing robots with losses in every drive, as real robots have. Adding one effect after another would
// take hours. Instead
//   - each joint is judged by its missing torque alone (evidence/torque/findings.h),
//   - links, feet and sensors by the equations without drives: balance, tilt, positions, gyroscope.
#pragma once

#include "diagnosis/evidence/torque/findings.h"
#include "diagnosis/report/report.h"
#include "diagnosis/standing/fit.h"

namespace hrp::diagnosis::standing {

using Progress = std::function<void(const std::string&)>;

// Returns false if the drives of most joints are as stated. `problems` must be prepared as in diagnose_standing().
bool diagnose_many_drives(const StandProblems& problems, int jobs, const Progress& progress, Reports* out);

}  // namespace hrp::diagnosis::standing
