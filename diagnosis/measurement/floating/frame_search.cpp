// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/floating/frame_search.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kStep = 0.02;       // [s] between moments that are compared
constexpr double kClock = 0.5;       // [s] by which a clock is looked for on either side
constexpr double kClockStep = 0.01;  // [s]
constexpr double kFar = 0.05;        // [s] of a clock that is moved: less is a sensor's delay, as in bags (docs/rosbag.md)
constexpr double kFastest = 0.05, kRateStep = 0.001;  // of clocks that run at another rate
constexpr size_t kOfClocks = 100;    // moments: 2 s, beside the margins
constexpr size_t kOfTurns = 25;      // moments: half a second, in which what is left of a walk changes its sign

// A clock that drifts leaves less than the best of all shifts, `moved`: none puts its readings where they belong.
bool drifts(const Left& left, const Matrix3d& R, double moved) {
  for (double rate = -kFastest; rate <= kFastest; rate += kRateStep) {
    if (left(R, {0.0, rate}) < moved) return true;
  }
  return false;
}

// Samples inside a clip that are kStep apart.
std::vector<size_t> list_samples(const Clip& clip, Purpose purpose) {
  const auto stride = static_cast<size_t>(std::max(1L, std::lround(kStep / clip.step)));
  const auto margin = clip.edge + static_cast<size_t>(purpose == Purpose::kForClocks ? std::lround(kClock / clip.step) : 0);
  std::vector<size_t> out;
  for (size_t k = margin; k + margin < clip.size(); k += stride) out.push_back(k);
  return out;
}

size_t get_least(Purpose purpose) { return purpose == Purpose::kForClocks ? kOfClocks : kOfTurns; }

double find_share(double part, double whole) { return whole > 0.0 ? part / whole : 1.0; }

}  // namespace

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
  const std::string margin = purpose == Purpose::kForClocks ? ", " + number(kClock) + " s from the ends of recordings and gaps" : " without gaps";
  return "that takes " + number(kStep * static_cast<double>(get_least(purpose))) + " s of motion" + margin + "; there are " +
         number(kStep * static_cast<double>(count), 2) + " s";
}

std::vector<Matrix3d> list_quarter_turns() {
  std::vector<Matrix3d> out{Matrix3d::Identity()};
  for (int x = 0; x < 6; ++x) {
    for (int y = 0; y < 6; ++y) {
      if (x % 3 == y % 3) continue;
      const Vector3d ex = (x < 3 ? 1.0 : -1.0) * Vector3d::Unit(x % 3), ey = (y < 3 ? 1.0 : -1.0) * Vector3d::Unit(y % 3);
      Matrix3d R;
      R << ex, ey, ex.cross(ey);
      if (!R.isIdentity()) out.push_back(R);
    }
  }
  return out;
}

size_t shift(size_t k, const Clock& clock, const Clip& clip, const LeggedLog& log) {
  const double since = clip.time[k] - log.experiment->recordings[clip.recording].time.front();
  const double time = std::clamp(clock.late + clock.rate * since, -kClock, kClock);
  return static_cast<size_t>(static_cast<long>(k) + std::lround(time / clip.step));
}

BestFrame find_best_turn(const Left& left, const BestFrame& start) {
  BestFrame best = start;
  const double nominal = left(Matrix3d::Identity(), {});
  double least = left(best.R, {best.late, 0.0});
  for (const Matrix3d& R : list_quarter_turns()) {
    const double here = left(R, {best.late, 0.0});
    if (here < least && here < kPart * nominal) least = here, best.R = R;
  }
  best.left = find_share(least, nominal);
  return best;
}

BestFrame find_best_clock(const Left& left, const BestFrame& turned) {
  BestFrame best = turned;
  const double nominal = left(Matrix3d::Identity(), {}), before = left(turned.R, {turned.late, 0.0});
  double least = before, late = turned.late;
  for (double t = -kClock; t <= kClock; t += kClockStep) {
    const double here = left(best.R, {t, 0.0});
    if (here < least) least = here, late = t;
  }
  const bool inside = std::abs(late) > kFar && std::abs(late) < kClock - kFar;
  if (!inside || least >= kPart * before || drifts(left, best.R, least)) return best;
  best.late = late, best.left = find_share(least, nominal);
  return best;
}

BestFrame find_best(const Left& left, const BestFrame& start) { return find_best_clock(left, find_best_turn(left, start)); }

}  // namespace hrp::diagnosis::floating
