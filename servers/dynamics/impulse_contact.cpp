// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/impulse_contact.h"

#include <algorithm>
#include <cmath>

#include "common/multibody/kinematics.h"
#include "common/multibody/mass_matrix.h"

namespace hrp {
namespace {

constexpr int kMaxImpulsePoints = 128;

Vector3d make_tangent(const Vector3d& n) {
  const Vector3d other = std::abs(n.x()) < 0.7 ? Vector3d::UnitX() : Vector3d::UnitY();
  return (other - n * n.dot(other)).normalized();
}

// In-place Cholesky factor (lower), L L^T = M. False when M is not positive definite.
bool factorise_in_place(Eigen::MatrixXd* M) {
  const Eigen::Index n = M->rows();
  for (Eigen::Index j = 0; j < n; ++j) {
    const double d = (*M)(j, j) - M->row(j).head(j).squaredNorm();
    if (!(d > 0.0) || !std::isfinite(d)) return false;
    const double root = std::sqrt(d);
    (*M)(j, j) = root;
    for (Eigen::Index i = j + 1; i < n; ++i) {
      (*M)(i, j) = ((*M)(i, j) - M->row(i).head(j).dot(M->row(j).head(j))) / root;
    }
  }
  return true;
}

void solve_lower(const Eigen::MatrixXd& L, Eigen::Ref<Eigen::VectorXd> x) {
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = (x[i] - L.row(i).head(i).dot(x.head(i))) / L(i, i);
}

void solve_lower_transposed(const Eigen::MatrixXd& L, Eigen::VectorXd* x) {
  const Eigen::Index n = x->size();
  for (Eigen::Index i = n - 1; i >= 0; --i) {
    (*x)[i] = ((*x)[i] - L.col(i).tail(n - 1 - i).dot(x->tail(n - 1 - i))) / L(i, i);
  }
}

}  // namespace

ImpulseContact::ImpulseContact(const ImpulseOptions& options, const Model& model) : options_(options) {
  order_.reserve(kMaxContactPoints);
  points_.reserve(kMaxImpulsePoints);
  M_.setZero(model.nv(), model.nv());
  J_.setZero(model.nv(), 3 * kMaxImpulsePoints);
  Y_.setZero(model.nv(), 3 * kMaxImpulsePoints);
  y_.setZero(model.nv());
  u_free_.setZero(3 * kMaxImpulsePoints);
  diagonal_.setZero(3 * kMaxImpulsePoints);
  correction_.setZero(model.nv());
}

void ImpulseContact::start_points(const ContactSet& contacts) {
  sort_contact_points(contacts, &order_);
  points_.clear();
  for (const PointIndex& index : order_) {
    const ContactPair& pair = contacts[static_cast<size_t>(index.pair)];
    const ContactPoint& contact = pair.points[static_cast<size_t>(index.point)];
    if (points_.size() == kMaxImpulsePoints) break;
    if (contact.depth < 0.0) continue;
    Point point;
    point.index = index;
    point.body_a = pair.body_a;
    point.body_b = pair.body_b;
    point.p = contact.p_WC;
    point.n = contact.n_BA_W;
    point.t1 = make_tangent(point.n);
    point.t2 = point.n.cross(point.t1);
    point.depth = contact.depth;
    point.friction = pair.friction;
    points_.push_back(point);
  }
}

// Columns of J^T, built along the path to the base: joint i moves point p by axis x (p - p_i) or by axis.
void ImpulseContact::add_body_rows(const Model& model, const Data& data, int body, double sign, int column) {
  if (body < 0) return;
  const Point& point = points_[static_cast<size_t>(column / 3)];
  const Vector3d* axes[3] = {&point.n, &point.t1, &point.t2};
  for (int link = body; link > 0; link = model.parent(link)) {
    const LinkKinematics& k = data.kinematics[static_cast<size_t>(link)];
    const bool slides = model.links()[static_cast<size_t>(link)].code == JointCode::kSlide;
    const Vector3d axis = small::to_eigen(k.axis);
    const Vector3d move = slides ? axis : Vector3d(axis.cross(point.p - small::to_eigen(k.p)));
    for (int c = 0; c < 3; ++c) J_(model.velocity_index(link), column + c) += sign * axes[c]->dot(move);
  }
  if (!model.floating()) return;
  const Vector3d r = point.p - small::to_eigen(data.kinematics[0].p);
  for (int c = 0; c < 3; ++c) {
    J_.block<3, 1>(0, column + c) += sign * r.cross(*axes[c]);
    J_.block<3, 1>(3, column + c) += sign * *axes[c];
  }
}

void ImpulseContact::fill_jacobian(const Model& model, const Data& data) {
  for (int i = 0; i < static_cast<int>(points_.size()); ++i) {
    J_.middleCols<3>(3 * i).setZero();
    add_body_rows(model, data, points_[static_cast<size_t>(i)].body_a, 1.0, 3 * i);
    add_body_rows(model, data, points_[static_cast<size_t>(i)].body_b, -1.0, 3 * i);
  }
}

Status ImpulseContact::factorise(const Model& model, const Eigen::VectorXd& inertia_extra, Data* data) {
  M_ = update_mass_matrix(model, data);
  for (int i = 0; i < model.num_joints(); ++i) M_(model.num_base() + i, model.num_base() + i) += inertia_extra[i];
  if (!factorise_in_place(&M_)) return Status::kSingular;
  for (int i = 0; i < 3 * static_cast<int>(points_.size()); ++i) {
    Y_.col(i) = J_.col(i);
    solve_lower(M_, Y_.col(i));
    diagonal_[i] = std::max(Y_.col(i).squaredNorm(), 1e-12);
  }
  return Status::kOk;
}

// With Y = L^-1 J^T and C = L^-1 Jc^T of the loops, G of the closed chain is Y^T (1 - Q Q^T) Y, Q orthonormal and
// spanning C: an impulse and what the loops answer to it.
void ImpulseContact::keep_loops_closed(const Eigen::MatrixXd& loops) {
  if (loops.rows() == 0) return;
  Eigen::MatrixXd C = loops.transpose(), Q(M_.rows(), loops.rows());
  for (Eigen::Index i = 0; i < C.cols(); ++i) solve_lower(M_, C.col(i));
  const double largest = C.colwise().squaredNorm().maxCoeff();
  Eigen::Index rank = 0;
  for (Eigen::Index i = 0; i < C.cols(); ++i) {
    Eigen::VectorXd c = C.col(i);
    for (int twice = 0; twice < 2; ++twice) c -= Q.leftCols(rank) * (Q.leftCols(rank).transpose() * c).eval();
    if (c.squaredNorm() > 1e-12 * largest) Q.col(rank++) = c.normalized();  // a planar four-bar has three rows too many
  }
  for (int i = 0; i < 3 * static_cast<int>(points_.size()); ++i) {
    Y_.col(i) -= Q.leftCols(rank) * (Q.leftCols(rank).transpose() * Y_.col(i)).eval();
    diagonal_[i] = std::max(Y_.col(i).squaredNorm(), 1e-12);
  }
}

double ImpulseContact::row_dot(int row) const { return u_free_[row] + Y_.col(row).dot(y_); }

void ImpulseContact::change_impulse(int row, double delta) { y_ += delta * Y_.col(row); }

// [H03 section 3.1]. One visit to a point: normal impulse, then friction on the circle of radius mu P_n. Returns the
// largest change.
double ImpulseContact::sweep_point(int i) {
  Point& point = points_[static_cast<size_t>(i)];
  const Vector3d before = point.P;
  const int row = 3 * i;
  point.P[0] = std::max(0.0, point.P[0] + (point.target - row_dot(row)) / diagonal_[row]);
  change_impulse(row, point.P[0] - before[0]);
  // One step size for both tangents keeps the friction's direction.
  const double size = std::max(diagonal_[row + 1], diagonal_[row + 2]);
  Eigen::Vector2d tangential = point.P.tail<2>();
  tangential.x() -= row_dot(row + 1) / size;
  tangential.y() -= row_dot(row + 2) / size;
  const double limit = point.friction * point.P[0], length = tangential.norm();
  point.clipped = length > limit;
  if (point.clipped) tangential *= limit / length;
  point.P.tail<2>() = tangential;
  change_impulse(row + 1, point.P[1] - before[1]);
  change_impulse(row + 2, point.P[2] - before[2]);
  return (point.P - before).cwiseAbs().maxCoeff();
}

void ImpulseContact::sweep_all() {
  y_.setZero();
  double largest = 0.0;
  for (sweeps_ = 0; sweeps_ < options_.max_sweeps;) {
    double change = 0.0;
    for (int i = 0; i < static_cast<int>(points_.size()); ++i) {
      change = std::max(change, sweep_point(i));
      largest = std::max(largest, points_[static_cast<size_t>(i)].P[0]);
    }
    ++sweeps_;
    if (change <= options_.tolerance * std::max(largest, 1e-12)) break;
  }
}

Status ImpulseContact::solve(const ContactSet& contacts, const Model& model, const Eigen::VectorXd& inertia_extra,
                             const Eigen::VectorXd& v, const Eigen::VectorXd& v_free, const Eigen::MatrixXd& loops,
                             Data* data) {
  start_points(contacts);
  fill_jacobian(model, *data);
  const Status status = factorise(model, inertia_extra, data);
  if (status != Status::kOk) return status;
  keep_loops_closed(loops);
  for (int i = 0; i < 3 * static_cast<int>(points_.size()); ++i) u_free_[i] = J_.col(i).dot(v_free);
  for (int i = 0; i < static_cast<int>(points_.size()); ++i) {
    const double speed = J_.col(3 * i).dot(v);
    points_[static_cast<size_t>(i)].target =
        speed < -options_.restitution_threshold ? -options_.restitution * speed : 0.0;
  }
  sweep_all();
  return Status::kOk;
}

void ImpulseContact::add(const Data& data, double dt, LinkWrenches* wrenches) const {
  for (const Point& point : points_) {
    const Vector3d f = (point.n * point.P[0] + point.t1 * point.P[1] + point.t2 * point.P[2]) / dt;
    for (const auto& [body, sign] : {std::pair<int, double>{point.body_a, 1.0}, {point.body_b, -1.0}}) {
      if (body < 0) continue;
      Vector6d& F = (*wrenches)[static_cast<size_t>(body)];
      const Vector3d r = point.p - small::to_eigen(data.kinematics[static_cast<size_t>(body)].p);
      F.head<3>() += sign * r.cross(f);
      F.tail<3>() += sign * f;
    }
  }
}

const Eigen::VectorXd& ImpulseContact::correction_velocity(double dt) {
  correction_.setZero();
  const bool deep =
      std::any_of(points_.begin(), points_.end(), [&](const Point& point) { return point.depth > options_.slop; });
  if (!deep) return correction_;
  for (int sweep = 0; sweep < 50; ++sweep) {
    for (int i = 0; i < static_cast<int>(points_.size()); ++i) {
      const double surplus = std::max(0.0, points_[static_cast<size_t>(i)].depth - options_.slop);
      const double wanted = options_.correction / dt * surplus;
      const double missing = wanted - Y_.col(3 * i).dot(correction_);
      if (missing > 0.0) correction_ += missing / diagonal_[3 * i] * Y_.col(3 * i);
    }
  }
  solve_lower_transposed(M_, &correction_);
  return correction_;
}

void ImpulseContact::report(double dt, const Eigen::VectorXd& v_end, ContactReport* report) const {
  for (size_t i = 0; i < points_.size(); ++i) {
    const Point& point = points_[i];
    const auto row = static_cast<Eigen::Index>(3 * i);
    PointForce& force = report->point(point.index);
    force.spring = point.n * (point.P[0] / dt);
    force.friction = (point.t1 * point.P[1] + point.t2 * point.P[2]) / dt;
    force.slip = point.t1 * J_.col(row + 1).dot(v_end) + point.t2 * J_.col(row + 2).dot(v_end);
    force.clipped = point.clipped;
  }
  report->finish();
}

}  // namespace hrp
