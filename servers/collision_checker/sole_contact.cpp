// SPDX-License-Identifier: BSD-3-Clause
#include "servers/collision_checker/sole_contact.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace hrp {
namespace {

constexpr int kMostPoints = 16;        // scenario.max_sole_points is at most this
constexpr double kUpperMargin = 2e-3;  // [m]

// p_WQ: the sole's lowest point.
void add_point(const Vector3d& p_WQ, const GroundPlane& ground, double margin, std::vector<ContactPoint>* points) {
  const double clearance = ground.n_W.dot(p_WQ) - ground.offset;  // negative when it overlaps
  if (!(clearance < margin)) return;
  points->push_back({p_WQ - (0.5 * clearance) * ground.n_W, ground.n_W, -clearance});
}

// Two directions in the plane, fixed to link A.
void make_tangents(const Matrix3d& R_WA, const Vector3d& n_W, Vector3d* t1, Vector3d* t2) {
  Vector3d x = R_WA.col(0) - n_W * n_W.dot(R_WA.col(0));
  if (x.squaredNorm() < 0.01) x = R_WA.col(1) - n_W * n_W.dot(R_WA.col(1));
  *t1 = x.normalized();
  *t2 = n_W.cross(*t1);
}

int find_deepest(const std::vector<ContactPoint>& points) {
  int best = 0;
  for (size_t i = 1; i < points.size(); ++i) {
    if (points[i].depth > points[size_t(best)].depth) best = static_cast<int>(i);
  }
  return best;
}

}  // namespace

double find_upper_margin(double margin) { return std::min(margin, kUpperMargin); }

double find_margin(const Sole& sole, const SolePoint& point, double margin) {
  return point.p_LQ.z() < sole.p_LR.z() + kUpperMargin ? margin : find_upper_margin(margin);
}

void reduce_points(const Matrix3d& R_WA, const Vector3d& n_W, int max_points, std::vector<ContactPoint>* points) {
  max_points = std::min(max_points, kMostPoints);
  if (static_cast<int>(points->size()) <= max_points) return;
  Vector3d t1, t2;
  make_tangents(R_WA, n_W, &t1, &t2);
  std::array<int, kMostPoints> kept{};
  int count = 0;
  const Vector3d origin = points->front().p_WC;  // differences of positions: no loss far from the world's origin
  for (int k = 0; k < max_points; ++k) {
    const double angle = 2.0 * M_PI * (k + 0.5) / max_points;
    const Vector3d direction = std::cos(angle) * t1 + std::sin(angle) * t2;
    int best = 0;
    double furthest = -1e300;
    for (size_t i = 0; i < points->size(); ++i) {
      const double reach = direction.dot((*points)[i].p_WC - origin);
      if (reach <= furthest + 1e-9) continue;  // 1 nm: rounding does not choose
      furthest = reach;
      best = static_cast<int>(i);
    }
    if (std::find(kept.begin(), kept.begin() + count, best) == kept.begin() + count) kept[size_t(count++)] = best;
  }
  int shallowest = 0;
  double most = 0.0;
  for (int i = 0; i < count; ++i) {
    const double depth = (*points)[size_t(kept[size_t(i)])].depth;
    most = std::max(most, depth);
    if (depth < (*points)[size_t(kept[size_t(shallowest)])].depth) shallowest = i;
  }
  const int deepest = find_deepest(*points);
  if ((*points)[size_t(deepest)].depth > 1.1 * most + 1e-6) kept[size_t(shallowest)] = deepest;
  std::sort(kept.begin(), kept.begin() + count);
  for (int i = 0; i < count; ++i) (*points)[size_t(i)] = (*points)[size_t(kept[size_t(i)])];
  points->resize(size_t(count));
}

void update_separation(ContactPair* pair) {
  pair->separation.setZero();
  pair->separation_turn.setZero();
  if (pair->points.empty()) return;
  const ContactPoint& deepest = pair->points[size_t(find_deepest(pair->points))];
  const Vector3d n = deepest.n_BA_W;
  pair->separation = deepest.depth * n;
  if (pair->points.size() < 2) return;
  Vector3d t1, t2;
  make_tangents(Matrix3d::Identity(), n, &t1, &t2);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double mean_depth = 0.0;
  const double share = 1.0 / static_cast<double>(pair->points.size());
  const auto project = [&](const ContactPoint& point) {
    const Vector3d p_RC = point.p_WC - pair->p_WR;
    return Eigen::Vector2d(t1.dot(p_RC), t2.dot(p_RC));
  };
  for (const ContactPoint& point : pair->points) {
    mean += share * project(point);
    mean_depth += share * point.depth;
  }
  Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  for (const ContactPoint& point : pair->points) {
    const Eigen::Vector2d t = project(point) - mean;
    A += t * t.transpose();
    b += t * (point.depth - mean_depth);
  }
  // Smallest gradient that fits: directions without extent (below 1e-6 of the other) get none.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(A);
  Eigen::Vector2d g = Eigen::Vector2d::Zero();
  for (int i = 0; i < 2; ++i) {
    const double spread = solver.eigenvalues()[i];
    if (spread <= 1e-6 * solver.eigenvalues()[1] || spread <= 1e-12) continue;
    g += solver.eigenvectors().col(i) * (solver.eigenvectors().col(i).dot(b) / spread);
  }
  pair->separation_turn = (g.x() * t1 + g.y() * t2).cross(n);
}

bool calc_sole_contact(const Sole& sole, const Transform& X_WL, const GroundPlane& ground, int max_points,
                       ContactPair* pair) {
  pair->points.clear();
  const double upper = find_upper_margin(ground.margin);
  for (const SolePoint& point : sole.points) {
    const Vector3d p_WQ = X_WL * point.p_LQ - point.radius * ground.n_W;
    add_point(p_WQ, ground, find_margin(sole, point, ground.margin), &pair->points);
  }
  for (const SoleRim& rim : sole.rims) {
    Vector3d p_WQ[4];
    calc_rim_points(rim, X_WL, ground.n_W, p_WQ);
    for (const Vector3d& p : p_WQ) add_point(p, ground, upper, &pair->points);
  }
  if (pair->points.empty()) return false;
  pair->body_a = sole.link;
  pair->body_b = kGround;
  pair->p_WR = X_WL * sole.p_LR;
  update_separation(pair);  // of the whole patch
  reduce_points(X_WL.R, ground.n_W, max_points, &pair->points);
  return true;
}

}  // namespace hrp
