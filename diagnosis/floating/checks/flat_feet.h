// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "diagnosis/floating/log/legged_log.h"

namespace hrp::diagnosis::floating {

// Whether a foot stands flat, so that the model's legs tell how the body is turned over it.
inline bool has_flat_foot(const LeggedLog& log) {
  return std::any_of(log.feet.begin(), log.feet.end(), [](const Foot& f) { return f.flat; });
}

}  // namespace hrp::diagnosis::floating
