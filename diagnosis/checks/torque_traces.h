// SPDX-License-Identifier: BSD-3-Clause
// Torque curves for the page: recorded effort, nominal model, and model with findings.
#pragma once

#include <nlohmann/json.hpp>

#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

// `torque_traces` of series.json: {"recording", "signals": [{"name", "unit"}], "traces": [{"signal", "time",
// "recorded", "before", "after"}]}. Shows the joints with the largest missing torque, for ten seconds of a held-out
// recording around its largest value.
nlohmann::ordered_json make_torque_traces(const TorqueData& data, const nlohmann::ordered_json& findings);

}  // namespace hrp::diagnosis
