// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace hrp {

// Nodes of a COLLADA file may contain other nodes by reference (<instance_node>). Assimp 5.2 follows the references
// without a limit, until the stack or the memory ends. Empty when it can follow those of this text, else why not.
std::string find_node_fault(const std::string& collada);

// Corners of faces (<p>) are whole numbers. Assimp 5.2 stays at the first sign that belongs to none, such as a comma,
// and appends zeros until the memory ends. Empty when these lists have numbers only, else what they have.
std::string find_list_fault(const std::string& collada);

}  // namespace hrp
