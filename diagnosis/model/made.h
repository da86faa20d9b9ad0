// SPDX-License-Identifier: BSD-3-Clause
// How machines are made and read.
#pragma once

namespace hrp::diagnosis {

// [rad] Half a degree: sensors are screwed on and zeros of encoders are set no better, floors are no more level.
constexpr double kMountingError = 0.01;
// [rad] Largest gap between the teeth of a usable transmission.
constexpr double kMostPlay = 0.2;
// [s] No sensor or drive is later, nor does a damper take longer. Up to it, delays are linear in their columns.
constexpr double kLatest = 0.2;
// [rad/s] A faster joint certainly slips: the direction of its friction is known.
constexpr double kSlips = 0.02;

}  // namespace hrp::diagnosis
