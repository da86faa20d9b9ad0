// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/conventions/frame_search.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/slopes.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kFar = 0.05;  // [s] of a clock that is moved: less is a sensor's delay, as in bags (docs/rosbag.md)
constexpr size_t kOfClocks = 4 * kMomentsOfBlock;  // moments: 2 s, beside the margins
constexpr size_t kFewest = 4;                      // blocks: three degrees of freedom
constexpr int kHeldReadings = 20;                  // that are tried beside the first

// A clock that drifts leaves less than the best of all shifts, `moved`: none puts its readings where they belong.
bool drifts(const Left& left, const Matrix3d& R, const Clock& range, double moved) {
  for (double rate = -kMinor; rate <= kMinor; rate += kRelativeStep) {
    if (left(R, {0.0, rate, range.first, range.last}) < moved) return true;
  }
  return false;
}

// What clocks of a range leave, kClockStep apart.
std::vector<double> try_clocks(const Left& left, const Matrix3d& R, const Clock& range) {
  std::vector<double> out;
  const long steps = std::lround((range.last - range.first) / kClockStep);
  for (long i = 0; i <= steps; ++i)
    out.push_back(left(R, {range.first + kClockStep * static_cast<double>(i), 0.0, range.first, range.last}));
  return out;
}

// Samples inside a clip that are kBetweenMoments apart.
std::vector<size_t> list_samples(const Clip& clip, Purpose purpose) {
  const auto stride = static_cast<size_t>(std::max(1L, std::lround(kBetweenMoments / clip.step)));
  const Clock range = find_range(purpose);
  const auto count = [&](double time) { return clip.edge + static_cast<size_t>(std::lround(time / clip.step)); };
  std::vector<size_t> out;
  for (size_t k = count(-range.first); k + count(range.last) < clip.size(); k += stride) out.push_back(k);
  return out;
}

// In half a second what is left of a walk changes its sign, which is enough for turns.
size_t get_least(Purpose purpose) { return purpose == Purpose::kForTurns ? kMomentsOfBlock : kOfClocks; }

double find_share(double part, double whole) { return whole > 0.0 ? part / whole : 1.0; }

// Of a search over a few steps of a walk, what leaves the least may be only one of several valleys.
enum class Valleys { kAny, kOne };

// The clock of a range that leaves the least; that of `turned` where none leaves a quarter.
BestFrame find_clock(const Left& left, const Clock& range, const BestFrame& turned, Valleys valleys) {
  const std::vector<double> all = try_clocks(left, turned.R, range);
  const double before = left(turned.R, {turned.late, 0.0, range.first, range.last});
  const auto least = static_cast<size_t>(std::min_element(all.begin(), all.end()) - all.begin());
  const double late = range.first + kClockStep * static_cast<double>(least),
               farthest = std::max(-range.first, range.last);
  const bool inside = std::abs(late) > kFar && std::abs(late) < farthest - kFar;
  if (!inside || all[least] >= kPart * before || drifts(left, turned.R, range, all[least])) return turned;
  if (valleys == Valleys::kOne && repeats(all, least)) return turned;
  BestFrame best = turned;
  best.late = late;
  best.left = find_share(all[least], left(Matrix3d::Identity(), {0.0, 0.0, range.first, range.last}));
  return best;
}

}  // namespace

Clock find_range(Purpose purpose) {
  switch (purpose) {
    case Purpose::kForTurns: return {0.0, 0.0, 0.0, 0.0};
    case Purpose::kForFarBehind: return {0.0, 0.0, 0.0, kFarClock};
    case Purpose::kForFarAhead: return {0.0, 0.0, -kFarClock, 0.0};
    case Purpose::kForClocks: break;
  }
  return {};
}

void walk(const LeggedLog& log, Purpose purpose, const std::function<void(const Clip&, size_t, BodyMotion*)>& use) {
  for (const Clip& clip : log.clips) {
    BodyMotion motion(log, clip);
    for (size_t k : list_samples(clip, purpose)) {
      motion.update(k);
      use(clip, k, &motion);
    }
  }
}

size_t count_moments(const LeggedLog& log, Purpose purpose) {
  size_t count = 0;
  for (const Clip& clip : log.clips) count += list_samples(clip, purpose).size();
  return count;
}

bool is_enough(Purpose purpose, size_t count) { return count >= get_least(purpose); }

std::string describe_need(Purpose purpose, size_t count) {
  const std::string margin = purpose == Purpose::kForClocks
                                 ? ", " + number(kNearClock) + " s from the ends of recordings and gaps"
                                 : " without gaps";
  return "that takes " + number(kBetweenMoments * static_cast<double>(get_least(purpose))) + " s of motion" + margin +
         "; there are " + number(kBetweenMoments * static_cast<double>(count), 2) + " s";
}

std::vector<Matrix3d> list_quarter_turns() {
  std::vector<Matrix3d> out{Matrix3d::Identity()};
  for (int x = 0; x < 6; ++x) {
    for (int y = 0; y < 6; ++y) {
      if (x % 3 == y % 3) continue;
      const Vector3d ex = (x < 3 ? 1.0 : -1.0) * Vector3d::Unit(x % 3),
                     ey = (y < 3 ? 1.0 : -1.0) * Vector3d::Unit(y % 3);
      Matrix3d R;
      R << ex, ey, ex.cross(ey);
      if (!R.isIdentity()) out.push_back(R);
    }
  }
  return out;
}

double calc_block_odds(const std::vector<double>& gains) {
  double sum = 0.0, square = 0.0;
  for (double g : gains) {
    sum += g;
    square += g * g;
  }
  const auto n = static_cast<double>(gains.size());
  if (gains.size() < kFewest || square == 0.0) return 0.0;
  const double variance = square / n - sum * sum / (n * n);
  return std::copysign(0.5 * n * std::log(square / (n * std::max(variance, kRounding * square / n))), sum);
}

Clock find_best_held(const Left& left, const Matrix3d& R) {
  Clock best;
  double least = 1e300;
  for (int i = 0; i <= kHeldReadings; ++i) {
    Clock held;
    held.held = static_cast<double>(i) / kHeldReadings;
    const double here = left(R, held);
    if (here < least) {
      least = here;
      best = held;
    }
  }
  return best;
}

bool repeats(const std::vector<double>& left, size_t least) {
  const auto is_deep = [&](size_t i) { return kHalf * left[i] < left[least]; };
  size_t first = least, last = least;
  while (first > 0 && is_deep(first - 1)) --first;
  while (last + 1 < left.size() && is_deep(last + 1)) ++last;
  for (size_t i = 0; i < left.size(); ++i) {
    if ((i < first || i > last) && is_deep(i)) return true;
  }
  return false;
}

size_t shift(size_t k, const Clock& clock, const Clip& clip, const LeggedLog& log) {
  if (clock.held >= 0.0)
    return clip.edge + static_cast<size_t>(clock.held * static_cast<double>(clip.size() - 1 - 2 * clip.edge));
  const double since = clip.time[k] - log.experiment->recordings[clip.recording].time.front();
  const double time = std::clamp(clock.late + clock.rate * since, clock.first, clock.last);
  return static_cast<size_t>(static_cast<long>(k) + std::lround(time / clip.step));
}

BestFrame find_best_turn(const Left& left, const BestFrame& start) {
  BestFrame best = start;
  const double nominal = left(Matrix3d::Identity(), {});
  double least = left(best.R, {best.late, 0.0});
  for (const Matrix3d& R : list_quarter_turns()) {
    const double here = left(R, {best.late, 0.0});
    if (here < least && here < kPart * nominal) {
      least = here;
      best.R = R;
    }
  }
  best.left = find_share(least, nominal);
  return best;
}

BestFrame find_best_clock(const Left& left, const BestFrame& turned) {
  return find_clock(left, {}, turned, Valleys::kAny);
}

bool may_be_far(const Left& left, const BestFrame& turned) {
  return turned.late == 0.0 && kPart * left(turned.R, {}) > 1.0;
}

BestFrame find_far_clock(const Left& left, Purpose side, const BestFrame& turned) {
  return find_clock(left, find_range(side), turned, Valleys::kOne);
}

BestFrame find_best(const Left& left, const BestFrame& start) {
  return find_best_clock(left, find_best_turn(left, start));
}

}  // namespace hrp::diagnosis::floating
