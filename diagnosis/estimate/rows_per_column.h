// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace hrp::diagnosis {

// Samples for each column that is fitted, at least: fewer follow any law by chance.
constexpr long kRowsPerColumn = 10;

}  // namespace hrp::diagnosis
