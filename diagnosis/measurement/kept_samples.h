// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace hrp::diagnosis {

// Kept samples in a period of the filter's cutoff: enough to lose nothing, and few duplicates. They count as one, as
// the filter leaves no more freedom.
constexpr double kPerPeriod = 5.0;

}  // namespace hrp::diagnosis
