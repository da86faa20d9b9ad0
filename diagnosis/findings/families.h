// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace hrp::diagnosis {

// What is claimed when the single law cannot be: "dry friction" of "coulomb_friction". What is in no row of the table (a constant torque, a tilted base) is a zero.
std::string find_family_name(const std::string& effect);

}  // namespace hrp::diagnosis
