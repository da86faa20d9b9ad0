// SPDX-License-Identifier: BSD-3-Clause
// Numbers as reports print them.
#pragma once

#include <string>

namespace hrp::diagnosis {

// To so many significant digits; 0 for what is no number.
double round_to(double value, int digits);
// 100 with two digits is "100", not "1e+02"; from 1e5 on powers of ten.
std::string number(double value, int digits = 4);

}  // namespace hrp::diagnosis
