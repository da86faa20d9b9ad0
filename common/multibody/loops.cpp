// SPDX-License-Identifier: BSD-3-Clause
#include "common/multibody/loops.h"

#include <cmath>

#include "common/base/check.h"
#include "common/multibody/kinematics.h"

namespace hrp {
namespace {

int count_rows(LoopKind kind) {
  switch (kind) {
    case LoopKind::kBall: return 3;
    case LoopKind::kPin: return 5;
    case LoopKind::kWeld: return 6;
    case LoopKind::kCoupling: return 1;
  }
  return 0;
}

void check_constraint(const Model& model, const LoopConstraint& c) {
  if (c.kind == LoopKind::kCoupling) {
    HRP_CHECK(c.joint_a >= 0 && c.joint_a < model.num_joints() && c.joint_b >= 0 && c.joint_b < model.num_joints(),
              "joints " << c.joint_a << ", " << c.joint_b);
    return;
  }
  HRP_CHECK(c.link_a >= 0 && c.link_a < model.num_links() && c.link_b >= kWorldLink && c.link_b < model.num_links(),
            "links " << c.link_a << ", " << c.link_b);
}

// Rotation vector of R: exact, also near half a turn.
Vector3d calc_rotation_vector(const Matrix3d& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

}  // namespace

Loops::Loops(const Model& model, std::vector<LoopConstraint> constraints) : constraints_(std::move(constraints)) {
  int rows = 0;
  for (const LoopConstraint& constraint : constraints_) {
    check_constraint(model, constraint);
    rows += count_rows(constraint.kind);
  }
  J_ = Eigen::MatrixXd::Zero(rows, model.nv());
  J_a_ = J_b_ = Eigen::MatrixXd::Zero(6, model.nv());
  Jt_ = X_ = Eigen::MatrixXd::Zero(model.nv(), rows);
  G_ = Eigen::MatrixXd::Zero(rows, rows);
  position_error_ = velocity_error_ = bias_ = lambda_ = Eigen::VectorXd::Zero(rows);
  // Factored once: an Eigen::LDLT that has only been sized holds an enum that was never set, and is copied with it.
  solver_.compute(Eigen::MatrixXd::Identity(rows, rows));
}

// Rows of c = p_A - p_B in world axes, and of the turns.
void Loops::update_frames(const Model& model, const LoopConstraint& constraint, Data* data, int row) {
  const bool world = constraint.link_b == kWorldLink;
  const Transform X_WA = get_pose(*data, constraint.link_a) * constraint.X_AF;
  const Transform X_WB = world ? constraint.X_BF : get_pose(*data, constraint.link_b) * constraint.X_BF;
  calc_point_jacobian(model, *data, constraint.link_a, X_WA.p, J_a_);
  Vector6d V = calc_point_velocity(*data, constraint.link_a, X_WA.p);
  Vector6d A = calc_point_acceleration(*data, constraint.link_a, X_WA.p);
  w_WB_.setZero();
  if (!world) {
    calc_point_jacobian(model, *data, constraint.link_b, X_WB.p, J_b_);
    J_a_ -= J_b_;
    const Vector6d V_WB = calc_point_velocity(*data, constraint.link_b, X_WB.p);
    w_WB_ = V_WB.head<3>();
    V -= V_WB;
    A -= calc_point_acceleration(*data, constraint.link_b, X_WB.p);
  }
  w_AB_ = V.head<3>();
  alpha_AB_ = A.head<3>();
  J_.middleRows(row, 3) = J_a_.bottomRows(3);
  position_error_.segment<3>(row) = X_WA.p - X_WB.p;
  velocity_error_.segment<3>(row) = V.tail<3>();
  bias_.segment<3>(row) = A.tail<3>();
  if (constraint.kind != LoopKind::kBall) update_turns(constraint, X_WA, X_WB, row + 3);
}

// Rows along axes fixed in B: c = axis . (turn of A against B), cdot = axis . w_AB for small turns.
void Loops::update_turns(const LoopConstraint& constraint, const Transform& X_WA, const Transform& X_WB, int row) {
  const bool pin = constraint.kind == LoopKind::kPin;
  const Vector3d turn =
      pin ? Vector3d(X_WB.R.col(2).cross(X_WA.R.col(2))) : calc_rotation_vector(X_WA.R * X_WB.R.transpose());
  for (int k = 0; k < (pin ? 2 : 3); ++k) {
    const Vector3d axis = X_WB.R.col(k);
    J_.row(row + k).noalias() = axis.transpose() * J_a_.topRows(3);
    position_error_[row + k] = axis.dot(turn);
    velocity_error_[row + k] = axis.dot(w_AB_);
    bias_[row + k] = axis.dot(alpha_AB_) + w_WB_.cross(axis).dot(w_AB_);
  }
}

void Loops::update_coupling(const Model& model, const State& state, const LoopConstraint& c, int row) {
  J_.row(row).setZero();
  J_(row, model.num_base() + c.joint_a) += 1;
  J_(row, model.num_base() + c.joint_b) -= c.ratio;
  position_error_[row] = state.q[c.joint_a] - c.ratio * state.q[c.joint_b] - c.offset;
  velocity_error_[row] = state.qd[c.joint_a] - c.ratio * state.qd[c.joint_b];
  bias_[row] = 0;
}

void Loops::update(const Model& model, const State& state, Data* data) {
  data->scratch.setZero();
  update_accelerations(model, data->scratch, data);
  int row = 0;
  for (const LoopConstraint& constraint : constraints_) {
    if (constraint.kind == LoopKind::kCoupling) {
      update_coupling(model, state, constraint, row);
    } else {
      update_frames(model, constraint, data, row);
    }
    row += count_rows(constraint.kind);
  }
}

void Loops::solve_multipliers(const Eigen::VectorXd& free_acceleration) {
  G_.noalias() = J_ * X_;
  const double largest = rows() > 0 ? G_.diagonal().maxCoeff() : 0.0;
  G_.diagonal().array() += 1e-12 * largest;
  lambda_ = -bias_ - (2 * damping_ * frequency_) * velocity_error_ - (frequency_ * frequency_) * position_error_;
  lambda_.noalias() -= J_ * free_acceleration;
  solver_.compute(G_);
  solver_.solveInPlace(lambda_);
}

Status Loops::calc_forward_dynamics(const Model& model, const State& state, const Eigen::VectorXd& effort,
                                    const LinkWrenches* wrenches, const ImplicitTerms& implicit, Data* data,
                                    Eigen::VectorXd* vdot) {
  update(model, state, data);
  const Status status = hrp::calc_forward_dynamics(model, effort, wrenches, implicit, data, vdot);
  if (status != Status::kOk || rows() == 0) return status;
  Jt_ = J_.transpose();
  calc_responses(model, Jt_, data, &X_);
  solve_multipliers(*vdot);
  vdot->noalias() += X_ * lambda_;
  return std::isfinite(vdot->sum()) ? Status::kOk : Status::kNotFinite;
}

}  // namespace hrp
