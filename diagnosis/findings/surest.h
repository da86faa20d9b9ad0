// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace hrp::diagnosis {

// Probability that no finding exceeds, however clear it is: laws outside the table exist.
constexpr double kSurest = 0.99;

}  // namespace hrp::diagnosis
