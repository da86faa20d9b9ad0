// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/checks/gyro_map.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "common/spatial/turn.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/blocks.h"
#include "diagnosis/estimate/robust.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/model/made.h"

namespace hrp::diagnosis::floating {
namespace {

// [rad] deviation of turns: larger ones are conventions, which have been looked for
constexpr double kLikelyTurn = 0.5;

constexpr long kScale = 0, kTurn = 1, kZero = 4, kCount = 7;  // coefficients
using Coefficients = Eigen::Matrix<double, kCount, 1>;
using Information = Eigen::Matrix<double, kCount, kCount>;
using Slopes = Eigen::Matrix<double, 3, kCount>;

// true rate = exp(factor) R(turn) reading - zero
struct Map {
  double factor = 0;
  Matrix3d R = Matrix3d::Identity();
  Vector3d zero{0, 0, 0};
  Vector3d apply(const Vector3d& reading) const { return std::exp(factor) * (R * reading); }
};

struct Freedom {
  bool scale = true, turn = true;
};

const RateToldBy& find_nearest(const RateMoment& m, const Map& map) {
  const Vector3d rate = map.apply(m.reading) - map.zero;
  return *std::min_element(m.told.begin(), m.told.end(), [&](const RateToldBy& a, const RateToldBy& b) {
    return (a.A * rate - a.turn).squaredNorm() < (b.A * rate - b.turn).squaredNorm();
  });
}

struct Row {
  const RateToldBy* by;
  Vector3d left;
};

std::vector<Row> list_rows(const std::vector<RateMoment>& moments, const Map& map) {
  std::vector<Row> out;
  for (const RateMoment& m : moments) {
    const RateToldBy& by = find_nearest(m, map);
    out.push_back({&by, by.turn - by.A * (map.apply(m.reading) - map.zero)});
  }
  return out;
}

// Feet that land or slide leave much and tell little: weights of Cauchy's errors about the median.
std::vector<double> find_weights(const std::vector<Row>& rows) {
  std::vector<double> out;
  for (const Row& r : rows) out.push_back(r.left.squaredNorm());
  std::vector<double> copy = out;  // at -O2, GCC 12 takes a copy made by the call for memory that is freed wrongly
  const double usual = std::max(1e-12, find_median(std::move(copy)));
  for (double& s : out) s = 1 / (1 + s / usual);
  return out;
}

Slopes find_slopes(const RateMoment& m, const Row& row, const Map& map, const Freedom& free) {
  const Vector3d rate = map.apply(m.reading);
  Slopes out = Slopes::Zero();
  if (free.scale) out.col(kScale) = row.by->A * rate;
  for (int a = 0; a < 3 && free.turn; ++a) out.col(kTurn + a) = row.by->A * Vector3d::Unit(a).cross(rate);
  out.rightCols<3>() = -row.by->A;
  return out;
}

struct MapFit {
  Map map;
  std::vector<double> weights;
  Information covariance = Information::Identity();
  double left = 0;  // weighted sum of squares
};

// Sums of squares; a coefficient that is not free, or that no motion tells, stays.
Information sum_squares(const std::vector<RateMoment>& moments, const std::vector<Row>& rows, const MapFit& fit,
                        const Freedom& free, Coefficients* score,
                        std::map<std::pair<int, int>, Coefficients>* by_block) {
  Information sum = Information::Zero();
  score->setZero();
  double square = 0, weight = 0;
  for (size_t i = 0; i < rows.size(); ++i) {
    const Slopes x = find_slopes(moments[i], rows[i], fit.map, free);
    const Coefficients own = fit.weights[i] * (x.transpose() * rows[i].left);
    sum += fit.weights[i] * (x.transpose() * x);
    *score += own;
    if (by_block)
      by_block->try_emplace({moments[i].recording, moments[i].block}, Coefficients::Zero()).first->second += own;
    square += fit.weights[i] * rows[i].left.squaredNorm();
    weight += 3 * fit.weights[i];
  }
  const double noise = std::max(1e-12, square / std::max(1e-12, weight));
  const Eigen::AngleAxisd turned(fit.map.R);
  for (int a = 0; a < 3; ++a) {
    sum(kTurn + a, kTurn + a) += noise / (kLikelyTurn * kLikelyTurn);
    (*score)(kTurn + a) -= noise / (kLikelyTurn * kLikelyTurn) * turned.angle() * turned.axis()(a);
  }
  if (!free.scale) sum(kScale, kScale) = 1;
  return sum;
}

void step(const Coefficients& x, const Freedom& free, Map* map) {
  if (free.scale) map->factor = std::clamp(map->factor + x(kScale), -kFactor, kFactor);
  if (free.turn) map->R = make_turn(Vector3d(x.segment<3>(kTurn))).toRotationMatrix() * map->R;
  map->zero += x.tail<3>();
}

// `weights`: empty for those of the fit's own errors.
MapFit fit_map(const std::vector<RateMoment>& moments, const Freedom& free, const std::vector<double>& weights = {}) {
  MapFit out;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<Row> rows = list_rows(moments, out.map);
    out.weights = weights.empty() ? find_weights(rows) : weights;
    Coefficients score;
    const Information sum = sum_squares(moments, rows, out, free, &score, nullptr);
    step(sum.ldlt().solve(score), free, &out.map);
  }
  const std::vector<Row> rows = list_rows(moments, out.map);
  Coefficients score;
  std::map<std::pair<int, int>, Coefficients> blocks;
  const Information inverse = sum_squares(moments, rows, out, free, &score, &blocks).inverse();
  Information scatter = Information::Zero();
  for (const auto& [at, own] : blocks) scatter += own * own.transpose();
  const double widening = blocks.size() > 1 ? find_widening(blocks.size()) : 1e3;
  out.covariance = find_few(static_cast<double>(blocks.size())) * widening * widening * inverse * scatter * inverse;
  double weight = 0;
  for (size_t i = 0; i < rows.size(); ++i) {
    out.left += out.weights[i] * rows[i].left.squaredNorm();
    weight += 3 * out.weights[i];
  }
  // White noise, too: it has the prior of what no motion tells, of which blocks say nothing.
  out.covariance += std::max(1e-12, out.left / std::max(1e-12, weight)) * inverse;
  return out;
}

Vector3d get_turn(const MapFit& fit) {
  const Eigen::AngleAxisd turn(fit.map.R);
  return turn.angle() * turn.axis();
}

// The factor by the other regression, over that of the fit: errors of both sides bracket it.
double find_reverse(const std::vector<RateMoment>& moments, const MapFit& fit) {
  const std::vector<Row> rows = list_rows(moments, fit.map);
  double tt = 0, tu = 0;
  for (size_t i = 0; i < rows.size(); ++i) {
    const Vector3d u = rows[i].by->A * fit.map.apply(moments[i].reading), t = u + rows[i].left;
    tt += fit.weights[i] * t.squaredNorm();
    tu += fit.weights[i] * t.dot(u);
  }
  return tt / std::max(1e-12, tu);
}

std::vector<std::vector<RateMoment>> split(const std::vector<RateMoment>& moments) {
  std::map<int, std::vector<RateMoment>> each;
  for (const RateMoment& m : moments) each[m.recording].push_back(m);
  std::vector<std::vector<RateMoment>> out;
  for (auto& [recording, own] : each) out.push_back(std::move(own));
  return out;
}

size_t count_blocks(const std::vector<RateMoment>& moments) {
  std::map<std::pair<int, int>, int> blocks;
  for (const RateMoment& m : moments) ++blocks[{m.recording, m.block}];
  return blocks.size();
}

// Each recording that tells a value to half of it has half to twice the same one.
template <class Value>
bool is_same(const std::vector<MapFit>& each, double whole, const Value& find) {
  return std::all_of(each.begin(), each.end(), [&](const MapFit& own) {
    const auto [value, std] = find(own);
    return std > kHalf * std::abs(whole) || (value / whole > 0.5 && value / whole < 2);
  });
}

void judge_turn(const std::vector<MapFit>& each, GyroMap* out) {
  const double size = out->turn.norm();
  if (size < kMountingError) return;
  const Vector3d along = out->turn / size;
  const double square = out->turn.dot(out->turn_covariance.ldlt().solve(out->turn));
  out->may_be_turned = square > kSignificantVector * kSignificantVector && is_same(each, size, [&](const MapFit& own) {
                         const Matrix3d c = own.covariance.block<3, 3>(kTurn, kTurn);
                         return std::pair(along.dot(get_turn(own)), std::sqrt(along.dot(c * along)));
                       });
  out->is_turned = out->may_be_turned && out->turn_left < kNearlyAll;
}

void judge_scale(const std::vector<MapFit>& each, const MapFit& fit, double reverse, GyroMap* out) {
  const double by_reading = fit.map.factor, by_told = by_reading + std::log(std::max(1e-12, reverse)),
               middle = 0.5 * (by_reading + by_told);
  const double std = std::sqrt(fit.covariance(kScale, kScale)), width = std::abs(by_told - by_reading);
  out->scale = std::exp(-middle);
  out->scale_std = out->scale * std::hypot(std, 0.5 * width / kNinetyFive, kKnown / kNinetyFive);
  const double nearest = by_reading * by_told > 0 ? std::min(std::abs(by_reading), std::abs(by_told)) : 0.0;
  const bool sure = nearest > std::max(kKnown, kSignificantInJoint * std) && width < kBracket * std::abs(middle);
  out->is_scaled = sure && out->scale_left < kNearlyAll && is_same(each, by_reading, [](const MapFit& own) {
                     return std::pair(own.map.factor, std::sqrt(own.covariance(kScale, kScale)));
                   });
}

// [rad^2/s^2] What is left at a moment.
double find_usual(const std::vector<RateMoment>& moments, const Map& map) {
  std::vector<double> squares;
  for (const Row& r : list_rows(moments, map)) squares.push_back(r.left.squaredNorm());
  return find_median(std::move(squares));
}

// [rad^2/s^2] What is left of readings of another time. Of several that may tell a moment the nearest does, so that
// noise fits noise.
double find_by_chance(const std::vector<RateMoment>& moments) {
  std::vector<RateMoment> others;
  for (const std::vector<RateMoment>& own : split(moments)) {
    for (size_t i = 0; i < own.size(); ++i) {
      others.push_back(own[i]);
      others.back().reading = own[(i + own.size() / 2) % own.size()].reading;
    }
  }
  return find_usual(others, fit_map(others, {}).map);
}

}  // namespace

GyroMap find_gyro_map(const std::vector<RateMoment>& moments) {
  GyroMap out;
  if (count_blocks(moments) < kFewestBlocks) return out;
  const MapFit fit = fit_map(moments, {});
  std::vector<MapFit> each;
  for (const std::vector<RateMoment>& own : split(moments)) {
    if (count_blocks(own) >= kFewestBlocks) each.push_back(fit_map(own, {}));
  }
  out.told = true;
  out.turn = get_turn(fit);
  out.turn_covariance = fit.covariance.block<3, 3>(kTurn, kTurn);
  out.turn_left = fit.left / fit_map(moments, {true, false}, fit.weights).left;
  out.scale_left = fit.left / fit_map(moments, {false, true}, fit.weights).left;
  judge_turn(each, &out);
  judge_scale(each, fit, find_reverse(moments, fit), &out);
  const double usual = find_usual(moments, fit.map), by_chance = find_by_chance(moments);
  out.usual = std::sqrt(usual);
  out.of_another_time = std::sqrt(by_chance);
  // Readings have to fit what is told at their time better than readings of another time do.
  if (usual >= kHalf * by_chance) out.may_be_turned = out.is_turned = out.is_scaled = false;
  return out;
}

}  // namespace hrp::diagnosis::floating
