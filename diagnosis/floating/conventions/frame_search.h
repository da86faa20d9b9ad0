// SPDX-License-Identifier: BSD-3-Clause
// The search for quarter turns and for clocks that are far off, whatever tells what is left with them.
#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/log/body_motion.h"

namespace hrp::diagnosis::floating {

// [s] By which clocks are looked for on either side; and, where that finds none, on one side after the other.
constexpr double kNearClock = 0.5, kFarClock = 3.0;

// A clock behind that of the encoders, and more so by `rate` of the time since the recording's begin.
struct Clock {
  double late = 0.0;  // [s]
  double rate = 0.0;
  double first = -kNearClock, last = kNearClock;  // [s] what moments have readings for
  // Share of a clip at which the one reading was taken that stands for all; below 0: they are not held
  double held = -1.0;
};

// What a turn and a clock leave: an error in squares.
using Left = std::function<double(const Matrix3d& R, const Clock& clock)>;

// Moments that are compared lie so far inside a clip: turns need no margin, clocks that of their search. Clocks that
// are far behind need readings after the moments alone, clocks that are far ahead before them.
enum class Purpose { kForTurns, kForClocks, kForFarBehind, kForFarAhead };

// The clocks that moments of a purpose have readings for.
Clock find_range(Purpose purpose);
constexpr double kClockStep = 0.01;    // [s] between clocks that are tried
constexpr size_t kMostMoments = 4000;  // more tell no better
constexpr size_t kMomentsOfBlock = 25;
constexpr double kBetweenMoments = kBlock / kMomentsOfBlock;  // [s]

// Calls `use` with the moments of a log that its motion is known at.
void walk(const LeggedLog& log, Purpose purpose, const std::function<void(const Clip&, size_t, BodyMotion*)>& use);

// How many there are, whether so many tell it, and what it takes.
size_t count_moments(const LeggedLog& log, Purpose purpose);
bool is_enough(Purpose purpose, size_t count);
std::string describe_need(Purpose purpose, size_t count);

// The 24 turns that take axes onto axes, the identity first.
std::vector<Matrix3d> list_quarter_turns();

// The sample at which a clock read what the encoders' clock has at k.
size_t shift(size_t k, const Clock& clock, const Clip& clip, const LeggedLog& log);

// A turn and a clock that leave the least. What does not leave a quarter is no better than the model's.
struct BestFrame {
  Matrix3d R = Matrix3d::Identity();
  double late = 0.0;  // [s]
  double left = 1.0;  // share in squares
  bool is_nominal() const { return R.isIdentity(1e-9) && late == 0.0; }
};

// `start`: what is known by now.
BestFrame find_best(const Left& left, const BestFrame& start = {});
BestFrame find_best_turn(const Left& left, const BestFrame& start = {});
BestFrame find_best_clock(const Left& left, const BestFrame& turned);

// Whether so much is left that a clock beyond find_best_clock()'s may be the cause. `left`: 1 of a sensor that agrees.
bool may_be_far(const Left& left, const BestFrame& turned);
// On one side. `turned` where no clock leaves a quarter, or where two do as well: steps repeat.
BestFrame find_far_clock(const Left& left, Purpose side, const BestFrame& turned);

// The one reading that leaves the least if it stands for all.
Clock find_best_held(const Left& left, const Matrix3d& R);

// Whether another valley than that of the least is half as deep: a gait repeats, and so does what it leaves.
bool repeats(const std::vector<double>& left, size_t least);

// n log of the odds for what leaves less, by logarithms of what it leaves less in each block; negative: against it.
double calc_block_odds(const std::vector<double>& gains);

// The same, of what `a` and `b` leave by moment [1], over what may be left anyway. `block` of each moment: one
// observation of an error whose size is not known, its logarithm. Below zero: b leaves less.
template <class Block>
double calc_odds_by_block(const std::vector<Block>& block, const std::vector<double>& a, const std::vector<double>& b) {
  std::map<Block, std::pair<double, double>> sums;
  for (size_t i = 0; i < block.size(); ++i) {
    auto& [of_a, of_b] = sums[block[i]];
    of_a += 1.0 + a[i];
    of_b += 1.0 + b[i];
  }
  std::vector<double> gains;
  for (const auto& [key, left] : sums) gains.push_back(std::log(left.second / left.first));
  return calc_block_odds(gains);
}

// Whether blocks of half a second, one by one, are for a clock, not only their sum, against the log as it is and
// against a sensor that reads the same all the time. A robot that falls, or walks briskly, agrees with no reading as
// well as with one from before it moved.
template <class Moment, class Measure>
bool is_for(const std::vector<Moment>& moments, const Measure& measure, Purpose side, const BestFrame& far) {
  const Clock range = find_range(side), moved{far.late, 0.0, range.first, range.last};
  const Clock held = find_best_held(measure(moments), far.R);
  std::vector<double> over_logged, over_held;
  for (size_t begin = 0; begin + kMomentsOfBlock <= moments.size(); begin += kMomentsOfBlock) {
    const auto first = moments.begin() + static_cast<long>(begin);
    const std::vector<Moment> block(first, first + static_cast<long>(kMomentsOfBlock));
    const Left left = measure(block);
    const double here = left(far.R, moved);
    over_logged.push_back(std::log(left(far.R, range) / here));
    over_held.push_back(std::log(left(far.R, held) / here));
  }
  return calc_block_odds(over_logged) > kOdds && calc_block_odds(over_held) > kOdds;
}

// The far clock that leaves the least. `list`: the moments of a side, `measure`: what they leave.
template <class List, class Measure>
BestFrame find_far_clock(const List& list, const Measure& measure, const BestFrame& turned) {
  BestFrame best = turned;
  for (const Purpose side : {Purpose::kForFarBehind, Purpose::kForFarAhead}) {
    const auto moments = list(side);
    if (!is_enough(side, moments.size())) continue;
    const BestFrame far = find_far_clock(Left(measure(moments)), side, turned);
    const bool better = far.late != turned.late && (best.late == turned.late || far.left < best.left);
    if (better && is_for(moments, measure, side, far)) best = far;
  }
  return best;
}

}  // namespace hrp::diagnosis::floating
