// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace hrp {

constexpr double kGravity = 9.81;  // [m/s^2]

}  // namespace hrp
