// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/plain_model.h"

#include <cmath>

#include "common/multibody/inverse_dynamics.h"
#include "common/multibody/kinematics.h"

namespace hrp::diagnosis {
namespace {

constexpr double kStill = 0.02;  // [rad/s] slower samples have no clear direction of friction

// Normal equations of one joint: columns velocity, sign of velocity, acceleration.
struct Normal {
  Eigen::Matrix3d gram = Eigen::Matrix3d::Zero();
  Eigen::Vector3d projection = Eigen::Vector3d::Zero();
};

// Least squares with no negative coefficient: the most negative one is dropped until none is left.
Eigen::Vector3d solve(const Normal& normal) {
  bool use[3] = {true, true, true};
  for (int round = 0; round < 3; ++round) {
    Eigen::Matrix3d gram = normal.gram;
    Eigen::Vector3d projection = normal.projection;
    for (int i = 0; i < 3; ++i) {
      if (use[i]) continue;
      gram.row(i).setZero(), gram.col(i).setZero();
      gram(i, i) = 1, projection(i) = 0;
    }
    gram.diagonal().array() += 1e-12 * (1 + gram.diagonal().array());
    const Eigen::Vector3d x = gram.ldlt().solve(projection);
    Eigen::Index worst = 0;
    if (x.minCoeff(&worst) >= 0) return x;
    use[worst] = false;
  }
  return Eigen::Vector3d::Zero();
}

// Effort that drove a joint at sample k: recorded (`effort`, where there is one), else what the servo law says.
double find_effort(const JointLaws& laws, const std::vector<double>& effort, const JointColumns& columns,
                   const SmoothJoint& joint, size_t k) {
  if (!effort.empty()) return effort[k];
  if (columns.command.empty()) return std::nan("");
  const double rate = columns.command_rate.empty() ? 0.0 : columns.command_rate[k];
  const double u = calc_servo_effort(laws, columns.command[k] - joint.q[k], rate - joint.qd[k], 0.0);
  return std::max(-laws.effort_limit, std::min(laws.effort_limit, u));
}

void add_recording(const Problem& problem, int r, std::vector<Normal>* normals) {
  const Experiment& e = *problem.experiment;
  const Plant plant = make_plant(e, {});
  const SmoothRecording& smooth = problem.smooth[static_cast<size_t>(r)];
  Data data(*plant.model);
  State state = make_state(*plant.model);
  Eigen::VectorXd acceleration(e.num_joints()), effort(e.num_joints());
  const Recording& recording = e.recordings[static_cast<size_t>(r)];
  for (size_t k = smooth.start; k < recording.size(); ++k) {
    for (int j = 0; j < e.num_joints(); ++j) {
      const SmoothJoint& joint = smooth.joints[static_cast<size_t>(j)];
      state.q(j) = joint.q[k], state.qd(j) = joint.qd[k], acceleration(j) = joint.qdd[k];
    }
    update_kinematics(*plant.model, state, &data);
    calc_inverse_dynamics(*plant.model, acceleration, nullptr, &data, &effort);
    for (int j = 0; j < e.num_joints(); ++j) {
      const size_t i = static_cast<size_t>(j);
      const double given = find_effort(plant.laws[i], smooth.effort[i], recording.joints[i], smooth.joints[i], k);
      const double missing = given - effort(j), v = state.qd(j);
      if (!std::isfinite(missing) || std::abs(v) < kStill) continue;
      const Eigen::Vector3d row(v, v > 0 ? 1.0 : -1.0, acceleration(j));
      (*normals)[static_cast<size_t>(j)].gram += row * row.transpose();
      (*normals)[static_cast<size_t>(j)].projection += row * missing;
    }
  }
}

}  // namespace

std::vector<Eigen::Vector3d> fit_plain_model(const Problem& problem) {
  std::vector<Normal> normals(static_cast<size_t>(problem.experiment->num_joints()));
  for (int r : problem.train) add_recording(problem, r, &normals);
  std::vector<Eigen::Vector3d> fitted;
  for (const Normal& normal : normals) fitted.push_back(solve(normal));
  return fitted;
}

Hypothesis make_plain_model(const std::vector<Eigen::Vector3d>& fitted) {
  Hypothesis hypothesis;
  for (size_t i = 0; i < fitted.size(); ++i) {
    const int j = static_cast<int>(i);
    hypothesis.push_back({EffectId::kViscous, j, {fitted[i](0)}});
    hypothesis.push_back({EffectId::kCoulomb, j, {fitted[i](1), 0.0}});
    hypothesis.back().p.resize(list_infos(EffectId::kCoulomb).size(), 0.002);  // [rad/s] stick speed
    hypothesis.push_back({EffectId::kRotorInertia, j, {fitted[i](2)}});
  }
  return hypothesis;
}

}  // namespace hrp::diagnosis
