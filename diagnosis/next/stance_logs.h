// SPDX-License-Identifier: BSD-3-Clause
// Faults of the joints' logs. They change what is recorded of a standing robot, and nothing that it does.
#pragma once

#include <optional>
#include <vector>

#include "common/effects/world_spec.h"
#include "diagnosis/data/recording.h"
#include "diagnosis/report/json.h"

namespace hrp::diagnosis {

// Of one reading of a StanceRun.
struct LogFault {
  size_t channel = 0;
  SensorErrors errors;  // of a scalar reading: first components
};

// The fault of an effect of a report; empty if it is none, or of a reading that a StanceRun lacks.
std::optional<LogFault> find_log_fault(const Experiment& experiment, const Json& effect);

// Adds faults to readings of this many channels, in samples of kStretch: bias, scale, delay.
void add_log_faults(const std::vector<LogFault>& faults, size_t channels, std::vector<double>* readings);

}  // namespace hrp::diagnosis
