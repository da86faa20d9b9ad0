// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace hrp::diagnosis {

// [s] Errors of stretches of this length count as independent: longer than a step of a walk, the sway of a robot, or
// the filter of a log remembers.
constexpr double kBlock = 0.5;

// Blocks of which a spread is known to a third of itself, at least.
constexpr size_t kFewestBlocks = 6;

// Of a recording, for cross-validation and errors: two halves would hardly tell how much they differ.
constexpr int kStretches = 4;

}  // namespace hrp::diagnosis
