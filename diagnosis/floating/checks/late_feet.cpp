// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/checks/late_feet.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/robust.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/checks/weight_check.h"
#include "diagnosis/floating/conventions/force_clock.h"
#include "diagnosis/floating/conventions/frame_search.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/log/foot_sensors.h"
#include "diagnosis/floating/report/words.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kFarthest = 1.5;  // [s] by which one foot's force is looked for on either side: two steps

// Of one row: what is left, and how it changes with a delay of both sensors and with half a delay of one against the
// other.
struct Transfer {
  double y = 0;
  Eigen::Vector2d x{0, 0};
  int recording = 0, block = 0;
};

struct DelayFit {
  Eigen::Vector2d x{0, 0};
  double std = 0;               // of the second coefficient
  double left = 0, common = 0;  // sums of squares with both coefficients, and with the first one alone
  size_t blocks = 0;            // that tell
};

// Values less their mean over a recording: a weight is in none of them.
void center(std::vector<Transfer>* rows) {
  std::map<int, std::pair<Eigen::Vector3d, double>> sums;
  for (const Transfer& t : *rows) {
    auto& [sum, count] = sums.try_emplace(t.recording, Eigen::Vector3d::Zero(), 0.0).first->second;
    sum += Eigen::Vector3d(t.y, t.x(0), t.x(1));
    count += 1;
  }
  for (Transfer& t : *rows) {
    const auto& [sum, count] = sums.at(t.recording);
    t.y -= sum(0) / count;
    t.x -= sum.tail<2>() / count;
  }
}

DelayFit fit_delay(const std::vector<Transfer>& rows) {
  Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  double yy = 0;
  for (const Transfer& t : rows) {
    A += t.x * t.x.transpose();
    b += t.y * t.x;
    yy += t.y * t.y;
  }
  DelayFit out;
  if (!(A.determinant() > 1e-9 * A(0, 0) * A(1, 1))) return out;
  out.x = A.ldlt().solve(b);
  out.left = yy - b.dot(out.x);
  out.common = yy - b(0) * b(0) / A(0, 0);
  std::map<int, std::pair<Eigen::Vector2d, double>> scores;  // by block, with its information
  for (const Transfer& t : rows) {
    auto& [score, told] = scores.try_emplace(t.block, Eigen::Vector2d::Zero(), 0.0).first->second;
    score += (t.y - t.x.dot(out.x)) * t.x;
    told += t.x(1) * t.x(1);
  }
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  double all = 0, squares = 0;
  for (const auto& [block, s] : scores) {
    scatter += s.first * s.first.transpose();
    all += s.second;
    squares += s.second * s.second;
  }
  out.blocks = static_cast<size_t>(all * all / std::max(1e-300, squares));
  if (out.blocks < 2) return out;
  const Eigen::Matrix2d inverse = A.inverse();
  out.std = std::sqrt((inverse * scatter * inverse)(1, 1) * find_few(static_cast<double>(out.blocks))) *
            find_widening(out.blocks);
  return out;
}

// The two sensors, if there are two feet and each has one of the vertical force alone.
bool has_two(const LeggedLog& log) {
  return log.feet.size() == 2 && log.sensors.size() == 2 && log.feet[0].sensor != log.feet[1].sensor &&
         all_feel_it_alone(log);
}

std::vector<Transfer> list_transfers(const ChannelRows& c, const ColumnLayout& layout) {
  std::vector<Transfer> out;
  const int at[2] = {c.find_column(layout.sensor(0, kWrenchDelayColumn)),
                     c.find_column(layout.sensor(1, kWrenchDelayColumn))};
  if (at[0] < 0 || at[1] < 0) return out;
  for (size_t i = 0; i < c.rows(); ++i) {
    const double a = c.row(i)[at[0]], b = c.row(i)[at[1]];
    out.push_back({c.y[i], {a + b, 0.5 * (a - b)}, c.recording[i], c.block[i]});
  }
  return out;
}

// Whether each recording that tells a delay has half to twice the same one.
bool is_same_everywhere(const std::vector<Transfer>& rows, double delay) {
  std::map<int, std::vector<Transfer>> each;
  for (const Transfer& t : rows) each[t.recording].push_back(t);
  return std::all_of(each.begin(), each.end(), [&](const auto& recording) {
    const DelayFit own = fit_delay(recording.second);
    const bool told = own.blocks >= 2 && own.std < 0.5 * std::abs(delay);
    return !told || (own.x(1) / delay > 0.5 && own.x(1) / delay < 2);
  });
}

// What is left of the weight with one foot's force moved, by block: squares about the recording's mean.
class FarScan {
 public:
  explicit FarScan(std::vector<PressedStretch> stretches) : stretches_(std::move(stretches)) {}

  // [s] Late, above 0; 0: none leaves a quarter of the squares, or several do as well, or blocks are not for it.
  double find(size_t foot) const {
    const std::vector<double> before = list_left(foot, 0);
    const double nominal = sum(before);
    std::vector<double> left;
    const long steps = std::lround(kFarthest / kClockStep);
    for (long i = -steps; i <= steps; ++i) left.push_back(sum(list_left(foot, kClockStep * static_cast<double>(i))));
    const auto least = static_cast<size_t>(std::min_element(left.begin(), left.end()) - left.begin());
    const double late = kClockStep * (static_cast<double>(least) - static_cast<double>(steps));
    const bool inside = least > 0 && least + 1 < left.size();
    if (!inside || late <= kNearForce || left[least] > kPart * nominal || repeats(left, least)) return 0;
    const std::vector<double> after = list_left(foot, late);
    std::vector<double> gains;
    for (size_t i = 0; i < after.size(); ++i)
      gains.push_back(std::log(std::max(1e-12, before[i]) / std::max(1e-12, after[i])));
    return calc_block_odds(gains) > kOdds ? late : 0;
  }

 private:
  static double sum(const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0); }

  // Moments that have a reading for every shift.
  std::vector<double> list_left(size_t foot, double late) const {
    std::vector<double> out;
    for (const PressedStretch& s : stretches_) {
      const auto reach = static_cast<size_t>(std::lround(kFarthest / s.step)),
                 length = std::max<size_t>(1, static_cast<size_t>(std::lround(kBlock / s.step)));
      const long by = std::lround(late / s.step);
      std::vector<double> left;
      for (size_t k = reach; k + reach < s.needed.size(); ++k) {
        double y = -s.needed[k];
        for (size_t f = 0; f < s.force.size(); ++f)
          y += s.force[f][f == foot ? static_cast<size_t>(static_cast<long>(k) + by) : k];
        left.push_back(std::isfinite(y) ? y : 0.0);
      }
      const double mean = left.empty() ? 0.0 : sum(left) / static_cast<double>(left.size());
      for (size_t begin = 0; begin + length <= left.size(); begin += length) {
        double square = 0;
        for (size_t k = begin; k < begin + length; ++k) square += std::pow(left[k] - mean, 2);
        out.push_back(square);
      }
    }
    return out;
  }

  std::vector<PressedStretch> stretches_;
};

// A foot whose force is late by so much that it is pressed while it is in the air.
LateFoot find_far_foot(const LeggedLog& log) {
  const FarScan scan(list_pressed(log, MotionSource::kNone));
  LateFoot best;
  for (size_t f = 0; f < log.feet.size(); ++f) {
    const double late = scan.find(f);
    if (late <= best.delay) continue;
    best = {log.feet[f].sensor, log.feet[1 - f].sensor, late, kClockStep};
  }
  return best;
}

}  // namespace

LateFoot find_late_foot(const LeggedLog& log, const std::vector<ChannelRows>& channels, const ColumnLayout& layout) {
  const ChannelRows* c = find_weight_equation(channels);
  if (!c || !has_two(log) || c->rows() < kFewestOfItsOwn) return {};
  std::vector<Transfer> rows = list_transfers(*c, layout);
  if (rows.empty()) return {};
  if (const LateFoot far = find_far_foot(log); far.sensor >= 0) return far;
  center(&rows);
  const DelayFit fit = fit_delay(rows);
  const double delay = fit.x(1);
  const bool sure =
      fit.blocks >= kFewestBlocks && std::abs(delay) > std::max(kUnlikely * fit.std, kHalf * log.sample_time);
  if (!sure || fit.left > (1 - kDetail) * fit.common || !is_same_everywhere(rows, delay)) return {};
  if (std::abs(delay) > kNearForce) return {};  // columns are of first order, forces come and go
  const int late = delay > 0 ? 0 : 1;
  return {late, 1 - late, std::abs(delay), fit.std};
}

Finding make_late_finding(const LeggedLog& log, const LateFoot& late) {
  const EffectInfo& effect = get_laws().sensor_delay.info();
  const std::string name = "/wrench/" + log.sensors[static_cast<size_t>(late.sensor)].name;
  Finding f = make_finding(effect, {{"sensor", name}}, {make_value(effect, late.delay, late.std)});
  f.grade = Grade::kSupported;
  f.probability = 0.95;
  f.share = 1;
  f.weight = 0.5;
  f.statement = name + format(" is late by %.0f +- %.0f ms against ", 1e3 * late.delay, 1.96e3 * late.std) +
                "/wrench/" + log.sensors[static_cast<size_t>(late.other)].name +
                ": while the load moves from foot to foot, their sum is off.";
  return f;
}

}  // namespace hrp::diagnosis::floating
