// SPDX-License-Identifier: BSD-3-Clause
// Checks of recordings before any fit: rates, gaps, held samples, clocks, motion, and which effects the motion can show
// (docs/diagnosis.md). They are the first section of the page and the output of `hrp-diagnose --check`.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "diagnosis/conventions/remarks.h"
#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// `checks` of report.json: recordings, joints, remarks. `searched`: the stretches of long recordings that the search
// uses, or the same experiment; the motion checks use it.
nlohmann::ordered_json make_checks(const Experiment& experiment, const Experiment& searched,
                                   const ConventionRemarks& conventions = {});

// The same as text for a terminal.
std::string print_checks(const nlohmann::ordered_json& checks);

}  // namespace hrp::diagnosis
