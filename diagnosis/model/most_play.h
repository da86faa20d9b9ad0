// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace hrp::diagnosis {

// [rad] Largest gap between the teeth of a usable transmission.
constexpr double kMostPlay = 0.2;

}  // namespace hrp::diagnosis
