// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis {

// Text of estimates with the half widths of their 95 % intervals: "level 0.17 +- 0.04 N m, offset (0.1 +- 0.02, 0 +-
// 0.01) m".
std::string describe(const std::vector<Estimate>& parameters);

}  // namespace hrp::diagnosis
