// SPDX-License-Identifier: BSD-3-Clause
// A TreeSpec in DART, spoken to in our coordinates (state.h). For tests and benchmarks.
// DART 6 has no reflected rotor inertia: compare with a spec whose rotor inertias are zero.
#pragma once

#include <memory>

#include "common/multibody/state.h"
#include "common/multibody/tree_spec.h"

namespace hrp::engines {

class DartEngine {
 public:
  DartEngine(const TreeSpec& spec, const Vector3d& gravity_W);
  ~DartEngine();

  void set_state(const State& state);
  void set_effort(const Eigen::VectorXd& effort);
  void set_acceleration(const Eigen::VectorXd& vdot);

  // The calculations alone; the first touches the positions so that nothing is left from the last call.
  void touch();
  void run_forward_dynamics();
  void run_mass_matrix();
  void run_inverse_dynamics();

  Eigen::VectorXd get_acceleration() const;
  Eigen::MatrixXd get_mass_matrix() const;
  Eigen::VectorXd get_effort() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hrp::engines
