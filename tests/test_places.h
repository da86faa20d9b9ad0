// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

// Where this build is. CMake writes the definitions (tests/CMakeLists.txt).
namespace hrp {

std::string source_dir();  // the top of the tree
std::string bin_dir();     // the programs

}  // namespace hrp
