// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/conventions/signed_axes.h"

#include <Eigen/Geometry>
#include <utility>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis::floating {
namespace {

// All 48 ways to write three axes into three columns.
std::vector<Matrix3d> list_ways() {
  std::vector<Matrix3d> out = list_quarter_turns();
  for (size_t i = 0, turns = out.size(); i < turns; ++i) out.push_back(-out[i]);
  return out;
}

int count_changed(const Matrix3d& R) {
  int out = 0;
  for (int i = 0; i < 3; ++i) out += R(i, i) > kHalf ? 0 : 1;
  return out;
}

struct Trial {
  ImuAxes axes;
  std::vector<double> left;
  bool is_changed() const { return !axes.gyro.isIdentity() || !axes.accelerometer.isIdentity(); }
};

// What is known by now, and what its rival leaves.
struct Start {
  Trial known;
  std::vector<double> rival;
};

// Of the quantity that is as logged, in one more way.
Trial find_least(const std::vector<Instant>& at, const LeftInAxes& left, const Start& start, bool has_accelerometer) {
  const auto& [gyro, accelerometer] = start.known.axes;
  Trial best = start.known;
  for (int changed = 1; changed <= 3; ++changed) {
    Trial least;
    const auto consider = [&](const ImuAxes& axes) {
      Trial t{axes, left(axes)};
      if (least.left.empty() || find_square(t.left) < find_square(least.left)) least = std::move(t);
    };
    for (const Matrix3d& R : list_ways()) {
      if (count_changed(R) != changed) continue;
      if (gyro.isIdentity()) consider({R, accelerometer});
      if (accelerometer.isIdentity() && has_accelerometer) consider({gyro, R});
    }
    if (least.left.empty() || find_square(least.left) > kPart * find_square(start.known.left)) continue;
    if (calc_odds(at, least.left, start.rival) > kOdds && calc_odds(at, least.left, best.left) > kOdds)
      best = std::move(least);
  }
  return best;
}

}  // namespace

SignedAxes find_signed_axes(const std::vector<Instant>& at, const LeftInAxes& left, const std::vector<double>& as_taken,
                            bool has_accelerometer) {
  const Trial logged{{}, left({})};
  Trial best = find_least(at, left, {logged, as_taken}, has_accelerometer);
  if (!best.is_changed()) return {};
  if (has_accelerometer) best = find_least(at, left, {best, best.left}, true);
  return {best.axes, find_square(best.left) / find_square(logged.left)};
}

TurnAndSigns split_signs(const Matrix3d& R) {
  TurnAndSigns out{R, Vector3d::Ones()};
  if (R.determinant() > 0.0) return out;
  double widest = -4.0;  // no trace is less than -3
  for (int i = 0; i < 4; ++i) {
    Vector3d signs = i < 3 ? Vector3d::Ones() : Vector3d(-Vector3d::Ones());
    if (i < 3) signs(i) = -1.0;
    const Matrix3d Q = R * signs.asDiagonal();
    if (Q.trace() > widest) {
      widest = Q.trace();
      out = {Q, signs};
    }
  }
  return out;
}

std::string name_columns(const Matrix3d& R) {
  std::string out;
  for (int column = 0; column < 3; ++column) {
    Eigen::Index axis = 0;
    R.col(column).cwiseAbs().maxCoeff(&axis);
    out += std::string(out.empty() ? "" : " ") + (R(axis, column) < 0.0 ? "-" : "") + "xyz"[axis];
  }
  return out;
}

}  // namespace hrp::diagnosis::floating
