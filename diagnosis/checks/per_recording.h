// SPDX-License-Identifier: BSD-3-Clause
// What each recording alone asks for: the same model fitted to one recording at a time, in torque space.
#pragma once

#include <nlohmann/json.hpp>

#include "diagnosis/measurement/torque.h"

namespace hrp::diagnosis {

// `per_recording` of report.json: [{"effect", "where", "parameter", "unit", "each": [{"recording", "role", "value", "ci95"}],
// "verdict": "agree" or "differ"}]. Of findings at joints and links of a robot on a fixed base; held-out recordings, too:
// nothing of the report depends on these fits. Recordings differ when two values are apart by more than three of their
// standard deviations and by more than a tenth of the larger one.
nlohmann::ordered_json make_per_recording(const TorqueData& data, const nlohmann::ordered_json& findings);

}  // namespace hrp::diagnosis
