// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque_stribeck.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "diagnosis/estimate/series.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/torque_samples.h"

namespace hrp::diagnosis {
namespace {

constexpr double kFinest = 0.01, kWidest = 0.6;  // range of the velocities tried, relative to the fastest
constexpr double kStep = 1.2;           // ratio of successive velocities
constexpr long kParts = 4;              // of a recording
constexpr size_t kFewestGroups = 3;      // two hardly determine a variance

void widen(double value, double std, Range* range) {
  range->low = std::min(range->low, value - kNinetyFive * std), range->high = std::max(range->high, value + kNinetyFive * std);
}

struct Point {
  double velocity = 0.0, likelihood = -1e300, level = 0.0, level_std = 0.0, rest = 0.0, rest_std = 0.0;
};

// Least squares at one Stribeck velocity. `samples.x` has the level in column `at` and the excess in its last column. A
// negative excess gives an empty point.
Point fit_curve(const TorqueSamples& samples, long at, double velocity, double effective) {
  const long last = samples.x.cols() - 1;
  const Eigen::MatrixXd inverse = invert_gram(samples.x);
  const Eigen::VectorXd theta = inverse * (samples.x.transpose() * samples.y);
  const double rest = (samples.y - samples.x * theta).squaredNorm();
  // Residual square per independent sample: correlated samples do not add information.
  const double variance = rest / std::max(1.0, effective);
  const auto deviation = [&](double v) { return std::sqrt(std::max(0.0, variance * v)); };
  Point p;
  p.velocity = velocity, p.likelihood = -0.5 * effective * std::log(std::max(1e-300, rest));
  p.level = theta[at], p.rest = theta[at] + theta[last];
  p.level_std = deviation(inverse(at, at));
  p.rest_std = deviation(inverse(at, at) + inverse(last, last) + 2.0 * inverse(at, last));
  return theta[last] < 0.0 ? Point{} : p;
}

// Columns of the excess at the samples, by velocity [rad/s].
struct Excesses {
  std::vector<double> velocity;
  std::vector<Eigen::VectorXd> column;
};

Excesses list_excesses(const TorqueDesign& design, size_t i, const TorqueSamples& samples) {
  Excesses out;
  const double fastest = samples.of.col(2).maxCoeff(), slow = design.data->slow[static_cast<size_t>(design.joints[i].joint)];
  for (double v = std::max(slow, kFinest * fastest); v < kWidest * fastest; v *= kStep) {
    out.velocity.push_back(v);
    out.column.push_back(list_column(design, i, {&find_term_row(&TermRow::excess), design.joints[i].joint, v}));
  }
  return out;
}

std::vector<Point> scan(const TorqueSamples& of, long at, const Excesses& excesses, double effective) {
  TorqueSamples samples = of;
  samples.x.conservativeResize(Eigen::NoChange, samples.x.cols() + 1);
  std::vector<Point> points;
  for (size_t i = 0; i < excesses.velocity.size(); ++i) {
    samples.x.rightCols(1) = excesses.column[i];
    points.push_back(fit_curve(samples, at, excesses.velocity[i], effective));
  }
  return points;
}

// Null if every curve falls towards rest.
const Point* find_best(const std::vector<Point>& points) {
  const auto best = std::max_element(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.likelihood < b.likelihood; });
  return best == points.end() || best->velocity == 0.0 ? nullptr : &*best;
}

// Between the velocities tried: steps from one to the next would count as differences.
double find_log_velocity(const std::vector<Point>& points, const Point* best) {
  const Point *before = best - 1, *after = best + 1;
  const bool inside = best > points.data() && after < points.data() + points.size() && before->velocity > 0.0 && after->velocity > 0.0;
  return std::log(best->velocity) + (inside ? std::log(kStep) * calc_vertex(before->likelihood, best->likelihood, after->likelihood) : 0.0);
}

using Groups = std::vector<long>;  // by sample

// The samples of all other groups.
TorqueSamples leave_out(const TorqueSamples& all, const Groups& groups, long group, const Excesses& excesses, Excesses* left) {
  std::vector<long> rows;
  for (long k = 0; k < all.of.rows(); ++k) {
    if (groups[static_cast<size_t>(k)] != group) rows.push_back(k);
  }
  TorqueSamples out;
  out.x = all.x(rows, Eigen::all), out.y = all.y(rows);
  *left = {excesses.velocity, {}};
  for (const Eigen::VectorXd& column : excesses.column) left->column.push_back(column(rows));
  return out;
}

// Widens a range to that of the jackknife over groups (Tukey 1958): the variance of a value is (n - 1) / n times the
// squares of what it becomes without each group, about their mean.
void widen_by_jackknife(const std::vector<double>& values, Range* range) {
  Spread spread;
  for (double value : values) spread.add(value);
  widen(range->value, std::sqrt(static_cast<double>(values.size()) - 1.0) * spread.get(), range);
}

// Recordings, each in this many parts of its time.
Groups divide(const TorqueSamples& samples, long parts) {
  Groups groups;
  for (long k = 0; k < samples.of.rows(); ++k)
    groups.push_back(parts * std::lround(samples.of(k, 0)) + std::min(parts - 1, static_cast<long>(static_cast<double>(parts) * samples.of(k, 1))));
  return groups;
}

void widen_by_groups(const TorqueSamples& samples, const Groups& groups, long at, const Excesses& excesses, double effective, DryCurve* curve) {
  std::vector<double> level, rest, velocity;
  for (long group : std::set<long>(groups.begin(), groups.end())) {
    Excesses left;
    const TorqueSamples others = leave_out(samples, groups, group, excesses, &left);
    if (others.x.rows() <= others.x.cols() + 1) continue;
    const std::vector<Point> points = scan(others, at, left, effective);
    const Point* best = find_best(points);
    if (!best) continue;
    level.push_back(best->level), rest.push_back(best->rest), velocity.push_back(find_log_velocity(points, best));
  }
  if (level.size() < kFewestGroups) return;
  widen_by_jackknife(level, &curve->level), widen_by_jackknife(rest, &curve->rest);
  Range speed{std::log(curve->velocity.value), std::log(curve->velocity.low), std::log(curve->velocity.high)};
  widen_by_jackknife(velocity, &speed);
  curve->velocity.low = std::exp(speed.low), curve->velocity.high = std::exp(speed.high);
}

// Removes the Stribeck excess from the joint's model. Returns the column of the level, or -1 if there is none.
long take_level(const TorqueDesign& design, size_t i, TorqueModel* model) {
  const JointDesign& joint = design.joints[i];
  std::vector<size_t> own;
  long at = -1, column = 0;
  for (size_t t : model->own[i]) {
    if (joint.terms[t].row->excess) continue;
    if (joint.terms[t].row->level) at = column;
    column += joint.terms[t].columns();
    own.push_back(t);
  }
  model->own[i] = own;
  return at;
}

}  // namespace

DryCurve profile_dry_curve(const TorqueDesign& design, const TorqueModel& given, size_t i) {
  DryCurve curve;
  TorqueModel model = given;
  const long at = take_level(design, i, &model);
  if (at < 0) return curve;
  TorqueSamples samples = list_torque_samples(design, model, i);
  if (samples.x.rows() <= samples.x.cols() + 1) return curve;
  const double effective = std::max(4.0, design.joints[i].effective);
  const Eigen::VectorXd plain = invert_gram(samples.x) * (samples.x.transpose() * samples.y);
  const double without = -0.5 * effective * std::log(std::max(1e-300, (samples.y - samples.x * plain).squaredNorm()));
  const Excesses excesses = list_excesses(design, i, samples);
  const std::vector<Point> points = scan(samples, at, excesses, effective);
  const Point* best = find_best(points);
  if (!best) return curve;
  curve.there = true, curve.gain = best->likelihood - without;
  curve.velocity = {best->velocity, best->velocity, best->velocity};
  curve.level = {best->level, best->level, best->level}, curve.rest = {best->rest, best->rest, best->rest};
  for (const Point& p : points) {
    // Depth of the 95 % region: half the 95 % quantile of chi-square with two parameters (velocity, excess).
    if (p.likelihood < best->likelihood - kOdds || p.velocity == 0.0) continue;
    curve.velocity.low = std::min(curve.velocity.low, p.velocity / kStep);
    curve.velocity.high = std::max(curve.velocity.high, p.velocity * kStep);
    widen(p.level, p.level_std, &curve.level), widen(p.rest, p.rest_std, &curve.rest);
  }
  // The likelihood knows the noise. Friction that is uneven, or fades as the drive warms up, differs between recordings, and
  // between their parts where a joint moved in one or two recordings only.
  for (long parts : {1L, kParts}) widen_by_groups(samples, divide(samples, parts), at, excesses, effective, &curve);
  return curve;
}

}  // namespace hrp::diagnosis
