// SPDX-License-Identifier: BSD-3-Clause
// Diagnosis of legged robots with losses in every drive, whatever their sensors and whether they walk:
//   - each joint is judged by its missing torque alone (evidence/torque/findings.h),
//   - bodies, soles and sensors by the equations of floating/ without drives.
#pragma once

#include "diagnosis/floating/diagnose.h"
#include "diagnosis/report/report.h"

namespace hrp::diagnosis::many_drives {

// Returns false if the drives of most joints are as stated, or nothing tells the torques of joints.
bool diagnose_legged(const Experiment& experiment, int jobs, const std::function<void(const std::string&)>& progress,
                     Reports* out);

}  // namespace hrp::diagnosis::many_drives
