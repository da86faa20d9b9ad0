// SPDX-License-Identifier: BSD-3-Clause
// Closed chains: constraints between links of the tree, solved at the level of accelerations.
//
// A loop is cut at one joint, which becomes equations c(q) = 0 with J = dc/dv. With the accelerations a of the open
// tree and M the matrix that articulated bodies solve with (implicit terms included):
//   G = J M^-1 J^T,  (G + e 1) lambda = -(J a + Jdot v + 2 z w cdot + w^2 c),  vdot = a + M^-1 J^T lambda.
// z and w (Baumgarte, 1972) draw drift back; e = 1e-12 of G's largest diagonal entry lets equations be redundant (a
// planar four-bar has three too many). Cost: linear in joints times rows, plus the rows' cube.
#pragma once

#include <vector>

#include "common/multibody/forward_dynamics.h"

namespace hrp {

enum class LoopKind {
  kBall,      // 3 rows: origins of A and B coincide
  kPin,       // 5 rows: and their z axes
  kWeld,      // 6 rows: and all axes
  kCoupling,  // 1 row: q[joint_a] = ratio q[joint_b] + offset, as URDF's mimic
};

constexpr int kWorldLink = -1;

struct LoopConstraint {
  LoopKind kind = LoopKind::kBall;
  int link_a = 0;
  int link_b = kWorldLink;         // or kWorldLink: frame B stands in the world
  Transform X_AF;                  // frame A in link_a
  Transform X_BF;                  // frame B in link_b
  int joint_a = 0, joint_b = 0;    // kCoupling
  double ratio = 1.0, offset = 0;  // kCoupling
};

// Constraints of one model with all memory they need. The couplings of mimic joints are not added by themselves.
class Loops {
 public:
  Loops(const Model& model, std::vector<LoopConstraint> constraints);

  int rows() const { return static_cast<int>(position_error_.size()); }
  // w [1/s] and z of the pull-back; 0 switches it off.
  void set_stabilisation(double frequency, double damping_ratio) {
    frequency_ = frequency;
    damping_ = damping_ratio;
  }

  // J, errors c and cdot, and Jdot v for the state that update_kinematics has seen. Overwrites data->motion.
  void update(const Model& model, const State& state, Data* data);
  const Eigen::MatrixXd& jacobian() const { return J_; }
  const Eigen::VectorXd& position_error() const { return position_error_; }
  const Eigen::VectorXd& velocity_error() const { return velocity_error_; }

  // Forward dynamics of the closed chain. Calls update. No allocation.
  Status calc_forward_dynamics(const Model& model, const State& state, const Eigen::VectorXd& effort,
                               const LinkWrenches* wrenches, const ImplicitTerms& implicit, Data* data,
                               Eigen::VectorXd* vdot);
  // Constraint forces of the last calculation; J^T lambda acts on v.
  const Eigen::VectorXd& multipliers() const { return lambda_; }

 private:
  void update_frames(const Model& model, const LoopConstraint& constraint, Data* data, int row);
  void update_turns(const LoopConstraint& constraint, const Transform& X_WA, const Transform& X_WB, int row);
  void update_coupling(const Model& model, const State& state, const LoopConstraint& constraint, int row);
  void solve_multipliers(const Eigen::VectorXd& free_acceleration);

  std::vector<LoopConstraint> constraints_;
  double frequency_ = 50.0, damping_ = 1.0;  // returns within 0.1 s, stable at steps up to 10 ms
  Eigen::MatrixXd J_, J_a_, J_b_, Jt_, X_, G_;
  Eigen::VectorXd position_error_, velocity_error_, bias_, lambda_;
  Vector3d w_AB_ = Vector3d::Zero(), w_WB_ = Vector3d::Zero(), alpha_AB_ = Vector3d::Zero();
  Eigen::LDLT<Eigen::MatrixXd> solver_;
};

}  // namespace hrp
