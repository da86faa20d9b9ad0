// SPDX-License-Identifier: BSD-3-Clause
// Steps of numerical slopes. Laws are smooth over them, and differences of double precision keep six digits.
#pragma once

namespace hrp::diagnosis {

// [rad, m, rad/s or m/s] over a position, an attitude, a rate.
constexpr double kSlopeStep = 1e-4;
// [s] over a delay, or between the delays of a scan: a tenth of the sampling time of a fast log.
constexpr double kTimeStep = 1e-3;
// Of a quantity's own size.
constexpr double kRelativeStep = 1e-3;
// Of a sum's own size: equal values of double precision, and their sums, differ by less.
constexpr double kRounding = 1e-9;

}  // namespace hrp::diagnosis
