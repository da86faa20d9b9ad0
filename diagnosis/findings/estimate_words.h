// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis {

// "level 0.17 +- 0.04 N m, offset (0.1 +- 0.02, 0 +- 0.01) m": values with the half widths of their 95 % intervals.
std::string describe(const std::vector<Estimate>& parameters);

}  // namespace hrp::diagnosis
