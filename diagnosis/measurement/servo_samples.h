// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace hrp::diagnosis {

// For a fit of a servo's law, at least. Neighbours resemble each other: some ten of them are independent.
constexpr size_t kLeastServoSamples = 100;

}  // namespace hrp::diagnosis
