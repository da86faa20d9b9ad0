// SPDX-License-Identifier: BSD-3-Clause
// Curves for people: efforts recorded, of the nominal model, and with what was found.
#pragma once

#include <nlohmann/json.hpp>

#include "diagnosis/measurement/torque.h"

namespace hrp::diagnosis {

// `torque_traces` of series.json: {"recording", "signals": [{"name", "unit"}], "traces": [{"signal", "time", "recorded",
// "before", "after"}]}: the joints of which most is missing, ten seconds of a held-out recording about the worst moment.
nlohmann::ordered_json make_torque_traces(const TorqueData& data, const nlohmann::ordered_json& findings);

}  // namespace hrp::diagnosis
