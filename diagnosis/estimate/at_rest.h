// SPDX-License-Identifier: BSD-3-Clause
// When something counts as at rest, and how long a short time is, for the times of machines: feet that land, logs with
// pauses, filters that settle.
#pragma once

namespace hrp::diagnosis {

// [rad or m] range of a joint, or of its command, below which it hardly moved: gears give by as much.
constexpr double kHardlyMoved = 0.02;
// [rad/s or m/s] of a joint or a foot that is faster than its encoder's noise: it moves.
constexpr double kMoving = 0.01;
// [s] between two rows of one stretch, at most, and between two stretches that are told apart.
constexpr double kPause = 0.15;
// [s] across which encoders' steps and the noise of derivatives average out, and within which two sensors feel one
// knock.
constexpr double kMoment = 0.05;
// [s] after a landing, before a lift, before a crash: feet scrape, filters reach so far.
constexpr double kScrape = 0.1;
// [s] A step, a jump (it would be 1.2 m high) or a fall to the ground takes less.
constexpr double kStepTakes = 1.0;

}  // namespace hrp::diagnosis
