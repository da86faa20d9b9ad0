// SPDX-License-Identifier: BSD-3-Clause
// Fits the same model to one recording at a time, from the missing torque.
#pragma once

#include <nlohmann/json.hpp>

#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

// `per_recording` of report.json: [{"effect", "where", "parameter", "unit", "each": [{"recording", "role", "value",
// "ci95"}], "verdict": "agree" or "differ"}]. For findings at joints of a robot on a fixed base, training and held-out
// recordings. The rest of the report does not depend on these fits. Recordings differ if two values differ by more than
// three of their standard deviations and by more than a tenth of the larger one.
nlohmann::ordered_json make_per_recording(const TorqueData& data, const nlohmann::ordered_json& findings);

}  // namespace hrp::diagnosis
