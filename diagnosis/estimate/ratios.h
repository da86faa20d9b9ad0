// SPDX-License-Identifier: BSD-3-Clause
// How many times as large is much larger: ratios of two sizes of one kind, such as a residual and the usual one. One
// scale of few steps, as in shares.h.
#pragma once

namespace hrp::diagnosis {

// Larger by what nobody overlooks. Two sizes within it are alike.
constexpr double kClearlyMore = 1.5;
// More than estimates of noise and details of laws ever differ.
constexpr double kSeveralTimes = 3.0;
// Another kind of thing: a spike beside noise, a gap beside a period, a force that presses beside one that drifts.
constexpr double kFarMore = 5.0;
// Of another order of magnitude.
constexpr double kTenTimes = 10.0;

}  // namespace hrp::diagnosis
