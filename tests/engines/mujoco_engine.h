// SPDX-License-Identifier: BSD-3-Clause
// A TreeSpec in MuJoCo, spoken to in our coordinates (state.h). For tests and benchmarks.
#pragma once

#include <string>
#include <vector>

#include "common/multibody/state.h"
#include "common/multibody/tree_spec.h"

struct mjModel_;
struct mjData_;

namespace hrp::engines {

// A point of link_a stays where it is in link_b with all joints at zero.
struct BallTie {
  int link_a, link_b;
  Vector3d p_AP;  // [m] in link_a
};

class MujocoEngine {
 public:
  // Every link a body with the same mass, centre and principal inertia; no contacts, limits or passive forces. Ties are
  // MuJoCo's connect constraints, as stiff as it allows: soft by 1e-4. They count in run_full_forward() only, which
  // leaves out what velocities do to them.
  MujocoEngine(const TreeSpec& spec, const Vector3d& gravity_W, const std::vector<BallTie>& ties = {});
  ~MujocoEngine();
  MujocoEngine(const MujocoEngine&) = delete;
  MujocoEngine& operator=(const MujocoEngine&) = delete;
  // False when MuJoCo refuses the tree; error() says why.
  bool usable() const { return data_ != nullptr; }
  const std::string& error() const { return error_; }

  void set_state(const State& state);
  void set_effort(const Eigen::VectorXd& effort);
  void set_acceleration(const Eigen::VectorXd& vdot);  // for calc_inverse_dynamics

  // The calculations alone, from positions and velocities on: what is timed.
  void run_forward_dynamics();
  void run_full_forward();  // mj_forward
  void run_mass_matrix();
  void run_inverse_dynamics();

  Eigen::VectorXd get_acceleration() const;  // after run_forward_dynamics, run_full_forward
  Eigen::MatrixXd get_mass_matrix() const;   // after run_mass_matrix
  Eigen::VectorXd get_effort() const;        // after run_inverse_dynamics

 private:
  Eigen::MatrixXd calc_coordinate_change() const;  // MuJoCo's velocity = T v

  int num_base_;
  Matrix3d R_WB_ = Matrix3d::Identity();
  std::vector<int> dofs_;       // of joint i
  std::vector<int> positions_;  // of joint i
  std::string error_;
  mjModel_* model_ = nullptr;
  mjData_* data_ = nullptr;
  Eigen::VectorXd force_;
};

}  // namespace hrp::engines
