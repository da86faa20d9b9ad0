// SPDX-License-Identifier: BSD-3-Clause
// Sensors behind the gears of a robot on a fixed base - joint torque, wrench, IMU, second encoder - beside a diagnosis
// from encoders and efforts: what they add to its report, confirm and exclude.
#pragma once

#include <set>

#include "diagnosis/evidence/links/findings.h"
#include "diagnosis/evidence/torque/findings.h"
#include "diagnosis/report/report.h"

namespace hrp::diagnosis {

// What drives lose between their effort and the torque behind their gears, the faults of that sensor that `links` has
// taken out. Of joints without such a sensor as everywhere else.
TorqueVerdict judge_drives(const Experiment& experiment, const LinkSensors& sensors, const LinkVerdict& links,
                           int jobs);

// Nothing changes without such sensors. `compared`: sources of columns that were compared, such as "/wrench/hand".
void add_link_evidence(const Experiment& experiment, const LinkSensors& sensors, int jobs, const Progress& progress,
                       Reports* reports, std::set<std::string>* compared);

}  // namespace hrp::diagnosis
