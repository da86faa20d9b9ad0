// SPDX-License-Identifier: BSD-3-Clause
// Random trees and states for tests, from fixed seeds.
#pragma once

#include <random>
#include <string>

#include "common/multibody/kinematics.h"
#include "common/multibody/model.h"

namespace hrp::testing {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double uniform(double low, double high) { return low + (high - low) * (engine_() / 4294967296.0); }
  int index(int n) { return static_cast<int>(uniform(0, n)); }
  Vector3d vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  Eigen::VectorXd values(Eigen::Index n, double size) {
    Eigen::VectorXd v(n);
    for (Eigen::Index i = 0; i < n; ++i) v[i] = uniform(-size, size);
    return v;
  }
  Matrix3d rotation() { return make_rotation_from_rpy(vector(3.1)); }

 private:
  std::mt19937 engine_;
};

inline LinkInertia make_random_inertia(Random* random) {
  LinkInertia inertia;
  inertia.mass = random->uniform(0.5, 5);
  inertia.p_LLcm_L = random->vector(0.1);
  const Vector3d half = Vector3d(0.05, 0.08, 0.11) + random->vector(0.03);  // a box: always a physical inertia
  const Vector3d s = half.cwiseAbs2() * (inertia.mass / 3);
  const Matrix3d R = random->rotation();
  inertia.I_LLcm_L = R * Vector3d(s.y() + s.z(), s.x() + s.z(), s.x() + s.y()).asDiagonal() * R.transpose();
  inertia.I_LLcm_L = (0.5 * (inertia.I_LLcm_L + inertia.I_LLcm_L.transpose())).eval();
  return inertia;
}

// Joints of every kind: coordinate axes of both signs, skew axes, sliding, with and without rotor, frames turned or
// not.
inline JointSpec make_random_joint(int i, Random* random) {
  JointSpec joint;
  joint.name = "joint" + std::to_string(i);
  joint.X_PF.p = random->vector(0.3);
  if (random->index(2) == 0) joint.X_PF.R = random->rotation();
  const int choice = random->index(9);
  if (choice < 6) {
    joint.axis_F = (choice % 2 == 0 ? 1.0 : -1.0) * Vector3d::Unit(choice / 2);
  } else {
    joint.axis_F = random->vector(1).normalized();
  }
  if (choice == 7 || i % 7 == 5) joint.kind = JointKind::kPrismatic;
  if (random->index(2) == 0) joint.rotor_inertia = random->uniform(0, 0.2);
  return joint;
}

inline TreeSpec make_random_tree(unsigned seed, int num_joints, bool floating) {
  Random random(seed);
  TreeSpec spec;
  spec.name = "random" + std::to_string(seed);
  spec.floating_base = floating;
  for (int i = 0; i <= num_joints; ++i) {
    LinkSpec link;
    link.name = "link" + std::to_string(i);
    link.inertia = make_random_inertia(&random);
    if (i > 0) {
      link.parent = random.index(3) == 0 ? random.index(i) : i - 1;
      link.joint = make_random_joint(i - 1, &random);
    }
    spec.links.push_back(link);
  }
  spec.frames.push_back({"tip", num_joints, {random.rotation(), random.vector(0.2)}});
  return spec;
}

inline State make_random_state(const Model& model, Random* random) {
  State state = make_state(model);
  state.R_WB = Eigen::Quaterniond(random->rotation());
  state.p_WB = random->vector(2);
  if (model.floating()) state.V_WB << random->vector(2), random->vector(2);
  state.q = random->values(model.num_joints(), 1.5);
  state.qd = random->values(model.num_joints(), 3);
  return state;
}

// Size of a difference relative to the larger of the two.
inline double relative_error(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return (a - b).norm() / std::max(1e-300, std::max(a.norm(), b.norm()));
}

}  // namespace hrp::testing
