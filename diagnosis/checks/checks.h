// SPDX-License-Identifier: BSD-3-Clause
// What recordings are like before anything is fitted: rates, gaps, held samples, clocks, motion, and what that motion can
// and cannot tell (docs/diagnosis.md). The first section of the page, and `hrp-diagnose --check`.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// `checks` of report.json: recordings, joints, remarks. `searched`: the stretches of long recordings that the search works
// with, else the same experiment: what it tells counts.
nlohmann::ordered_json make_checks(const Experiment& experiment, const Experiment& searched);

// The same for a terminal.
std::string print_checks(const nlohmann::ordered_json& checks);

}  // namespace hrp::diagnosis
