// SPDX-License-Identifier: BSD-3-Clause
// One self-contained page: table 1 (K, C, O), tables 2 and 3 (direct and cross validation), plots in the form of
// figures 4 and 7 to 13 of [M14], and the scenario with the bush that was found.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/identification/identify.h"

namespace hrp::identification {

// The places of the bushes' centres in their feet, as the observer uses them.
std::string write_identified_scenario(const Identification& result, const std::string& folder);
void write_report(const Identification& result, const std::string& path);
// The same numbers for the terminal.
std::string make_text(const Identification& result);

}  // namespace hrp::identification
