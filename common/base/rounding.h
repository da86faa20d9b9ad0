// SPDX-License-Identifier: BSD-3-Clause
// Formats numbers for reports.
#pragma once

#include <string>

namespace hrp {

// Rounds to significant digits; 0 for NaN and infinity.
double round_to(double value, int digits);
// Text with significant digits: 100 with two digits is "100", not "1e+02". Exponents from 1e5 on.
std::string number(double value, int digits = 4);

}  // namespace hrp
