// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/wrench_law.h"

#include <algorithm>
#include <cmath>

#include "servers/dynamics/scale_angular.h"

namespace hrp {
namespace {

constexpr int kMaxSweeps = 400;
constexpr double kPrecision = 1e-12;   // of the displacement, relative to the deepest point
constexpr double kIndependent = 1e-9;  // squared share of a row that earlier rows do not have

// Rows in units in which the spring's energy is half the squared length.
struct SeparationRows {
  Vector6d row[kMaxProjectionPoints];
  double square[kMaxProjectionPoints];
  double deepest = 0.0;
  int num = 0;

  SeparationRows(const Vector6d& root, const PairPoint* points, int count)
      : num(std::min(count, kMaxProjectionPoints)) {
    for (int i = 0; i < num; ++i) {
      row[i] << points[i].r.cross(points[i].n), points[i].n;
      row[i] = row[i].cwiseQuotient(root);
      square[i] = row[i].squaredNorm();
      deepest = std::max(deepest, points[i].depth);
    }
  }

  // Shortest y with row_i . y >= depth_i at every point; the multipliers are forces.
  Vector6d solve(const PairPoint* points, double* force) const {
    Vector6d y = Vector6d::Zero();
    for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
      double change = 0.0;
      for (int i = 0; i < num; ++i) {
        const double gap = points[i].depth - row[i].dot(y);
        const double step = std::max(gap / square[i], -force[i]);
        force[i] += step;
        y += step * row[i];
        change = std::max(change, std::abs(step) * square[i]);
      }
      if (change <= kPrecision * deepest) break;
    }
    return y;
  }
};

}  // namespace

PairDisplacement calc_pair_displacement(const WrenchLaw& law, const PairPoint* points, int num) {
  PairDisplacement found;
  found.force.fill(0.0);
  const Vector6d root = law.stiffness.cwiseSqrt();
  const SeparationRows rows(root, points, num);
  if (!(rows.deepest > 0.0)) return found;
  found.D = -rows.solve(points, found.force.data()).cwiseQuotient(root);
  Matrix6d span = Matrix6d::Zero();  // projection onto the rows of the points that push
  for (int i = 0; i < rows.num; ++i) {
    if (!(found.force[static_cast<size_t>(i)] > 0.0)) continue;
    const Vector6d rest = rows.row[i] - span * rows.row[i];
    if (rest.squaredNorm() > kIndependent * rows.square[i]) span += rest * rest.transpose() / rest.squaredNorm();
  }
  found.slope = root.asDiagonal() * span * root.asDiagonal();
  return found;
}

// [H03 eq. 1]
Vector6d calc_spring_wrench(const Vector6d& stiffness, const Vector6d& D) { return -stiffness.cwiseProduct(D); }

Vector6d calc_damping_coefficients(const WrenchLaw& law, const Vector6d& D) {
  const Vector6d lambda = 1.5 * law.alpha * law.stiffness;
  return lambda.cwiseProduct(D.cwiseAbs().array().pow(law.exponent).matrix());
}

// [H03 eq. 3]
Vector6d calc_damping_wrench(const WrenchLaw& law, const Vector6d& D, const Vector6d& V) {
  return -calc_damping_coefficients(law, D).cwiseProduct(V);
}

// [H03 eq. 4]
Vector6d calc_normal_wrench(const Vector6d& spring, const Vector6d& damper) { return spring + damper; }

double calc_wrench_norm(double length, const Vector6d& wrench) { return scale_angular(wrench, 1.0 / length).norm(); }

// P C P with P the projection orthogonal to the normal wrench, in scaled units and back.
Matrix6d calc_tangential_slope(const WrenchLaw& law, const Vector6d& normal) {
  const Vector6d n = scale_angular(normal, 1.0 / law.length);
  const double square = n.squaredNorm();
  if (!(square > 0.0)) return Matrix6d::Zero();
  const Matrix6d P = Matrix6d::Identity() - n * n.transpose() / square;
  const Vector6d unit = scale_angular(Vector6d::Ones(), law.length);
  const Vector6d C = law.damping.cwiseQuotient(unit.cwiseProduct(unit));
  return unit.asDiagonal() * (P * C.asDiagonal() * P) * unit.asDiagonal();
}

// [H03 eq. 5]
Vector6d calc_tangential_wrench(const WrenchLaw& law, const Vector6d& normal, const Vector6d& V) {
  return -calc_tangential_slope(law, normal) * V;
}

// [H03 eq. 6]
bool clip_wrench(double friction, double length, const Vector6d& normal, Vector6d* tangential) {
  const double limit = friction * calc_wrench_norm(length, normal);
  const double size = calc_wrench_norm(length, *tangential);
  if (size <= limit) return false;
  *tangential *= limit / size;
  return true;
}

}  // namespace hrp
