// SPDX-License-Identifier: BSD-3-Clause
// The state of a tree of rigid bodies.
#pragma once

#include <Eigen/Dense>

#include "common/spatial/transform.h"

namespace hrp {

// Order of generalised velocities v (floating base): [w_WB_W; v_WB_W; qd], size 6 + n. Fixed base: [qd], size n.
struct State {
  Eigen::Quaterniond R_WB = Eigen::Quaterniond::Identity();  // base attitude, unit norm
  Vector3d p_WB = Vector3d::Zero();                          // [m] base position
  Vector6d V_WB = Vector6d::Zero();  // [rad/s; m/s] base velocity, world axes; zero for a fixed base
  Eigen::VectorXd q;                 // [rad or m] joint positions
  Eigen::VectorXd qd;                // [rad/s or m/s] joint velocities

  Transform X_WB() const { return {R_WB.toRotationMatrix(), p_WB}; }
};

// Hash of the bits of the whole state (BitHash over the doubles in the order above): equal states, equal hashes.
unsigned long long calc_state_hash(const State& state);

}  // namespace hrp
