// SPDX-License-Identifier: BSD-3-Clause
// Judges findings from the stretches of long recordings on the complete recordings.
#pragma once

#include <nlohmann/json.hpp>

#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

// `on_all` of report.json: {"seconds", "searched": seconds of the stretches, "joints": [{"joint", "before", "after",
// "unit"}]}, root mean squares of the missing torque over every sample in motion; nothing is fitted to it.
nlohmann::ordered_json make_fit_on_all(const TorqueData& all, const Experiment& searched,
                                       const nlohmann::ordered_json& findings);

}  // namespace hrp::diagnosis
