// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace hrp {

// Nodes of a COLLADA file may contain other nodes by reference (<instance_node>). Assimp 5.2 follows the references
// without a limit, until the stack or the memory ends. Empty when it can follow those of this text, else why not.
std::string find_node_fault(const std::string& collada);

// Corners of faces (<p>) are whole numbers. Assimp 5.2 stays at the first sign that belongs to none, such as a comma,
// and appends zeros until the memory ends. It also reads beyond an array that has fewer numbers than its accessor says.
// Empty when neither can happen, else what is wrong.
std::string find_number_fault(const std::string& collada);

}  // namespace hrp
