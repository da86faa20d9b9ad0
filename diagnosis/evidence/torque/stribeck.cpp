// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque/stribeck.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/torque/samples.h"

namespace hrp::diagnosis {
namespace {

constexpr double kStep = 1.2;  // ratio of successive velocities

void widen(double value, double std, Range* range) {
  range->low = std::min(range->low, value - kNinetyFive * std);
  range->high = std::max(range->high, value + kNinetyFive * std);
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
  p.velocity = velocity;
  p.likelihood = -0.5 * effective * std::log(std::max(1e-300, rest));
  p.level = theta[at];
  p.rest = theta[at] + theta[last];
  p.level_std = deviation(inverse(at, at));
  p.rest_std = deviation(inverse(at, at) + inverse(last, last) + 2.0 * inverse(at, last));
  return theta[last] < 0.0 ? Point{} : p;
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
  const double effective = std::max(4.0, design.joints[i].effective), fastest = samples.of.col(2).maxCoeff();
  const double slow = design.data->slow[static_cast<size_t>(design.joints[i].joint)];
  const Eigen::VectorXd plain = invert_gram(samples.x) * (samples.x.transpose() * samples.y);
  const double without = -0.5 * effective * std::log(std::max(1e-300, (samples.y - samples.x * plain).squaredNorm()));
  samples.x.conservativeResize(Eigen::NoChange, samples.x.cols() + 1);
  std::vector<Point> points;
  // Nearer to the fastest, the whole curve looks like viscous friction.
  for (double v = std::max(slow, kTrace * fastest); v < kHalf * fastest; v *= kStep) {
    samples.x.rightCols(1) = list_column(design, i, {&find_term_row(&TermRow::excess), design.joints[i].joint, v});
    points.push_back(fit_curve(samples, at, v, effective));
  }
  const auto best = std::max_element(points.begin(), points.end(),
                                     [](const Point& a, const Point& b) { return a.likelihood < b.likelihood; });
  if (best == points.end() || best->velocity == 0.0) return curve;
  curve.there = true;
  curve.gain = best->likelihood - without;
  curve.velocity = {best->velocity, best->velocity, best->velocity};
  curve.level = {best->level, best->level, best->level};
  curve.rest = {best->rest, best->rest, best->rest};
  for (const Point& p : points) {
    // Depth of the 95 % region: half the 95 % quantile of chi-square with two parameters (velocity, excess).
    if (p.likelihood < best->likelihood - kOdds || p.velocity == 0.0) continue;
    curve.velocity.low = std::min(curve.velocity.low, p.velocity / kStep);
    curve.velocity.high = std::max(curve.velocity.high, p.velocity * kStep);
    widen(p.level, p.level_std, &curve.level);
    widen(p.rest, p.rest_std, &curve.rest);
  }
  return curve;
}

}  // namespace hrp::diagnosis
