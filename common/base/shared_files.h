// SPDX-License-Identifier: BSD-3-Clause
// Files that are installed beside the programs: scenarios, robots, the page of the viewer.
#pragma once

#include <string>

namespace hrp {

// The file or folder `name`, such as "viewer" or "models/scenarios/default.yaml", of this program's installation: in
// ../share/openhrp_dds, seen from the program, or in ../share of a build folder. Where nothing is, the first of the
// two.
std::string find_shared_file(const std::string& name);

// The scenario that a user means by `word`: a file as it is; else one that is installed, "default" or
// "paper_a/fig9.yaml". `word` itself where there is neither.
std::string find_scenario_file(const std::string& word);

}  // namespace hrp
