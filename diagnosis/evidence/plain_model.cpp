// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/plain_model.h"

#include <algorithm>
#include <cmath>

#include "common/multibody/kinematics.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/measurement/torque/term_rows.h"
#include "diagnosis/model/made.h"
#include "diagnosis/simulation/bodies.h"

namespace hrp::diagnosis {
namespace {

// Normal equations of one joint. Columns: velocity, sign of velocity, acceleration, load that drives the joint.
struct Normal {
  Eigen::Matrix4d gram = Eigen::Matrix4d::Zero();
  Eigen::Vector4d projection = Eigen::Vector4d::Zero();
};

// Least squares without negative coefficients: the most negative column is removed until none is negative.
Eigen::Vector4d solve(const Normal& normal, bool with_gear) {
  bool use[4] = {true, true, true, with_gear};
  for (int round = 0; round < 4; ++round) {
    Eigen::Matrix4d gram = normal.gram;
    Eigen::Vector4d projection = normal.projection;
    for (int i = 0; i < 4; ++i) {
      if (use[i]) continue;
      gram.row(i).setZero();
      gram.col(i).setZero();
      gram(i, i) = 1;
      projection(i) = 0;
    }
    gram.diagonal().array() += 1e-12 * (1 + gram.diagonal().array());
    Eigen::Vector4d x = gram.ldlt().solve(projection);
    Eigen::Index worst = 0;
    if (x.minCoeff(&worst) >= 0) return x;
    use[worst] = false;
  }
  return Eigen::Vector4d::Zero();
}

// Effort of a joint at sample k [N m]: recorded if `effort` is not empty, else from the servo law; NaN if neither
// exists.
double find_effort(const JointLaws& laws, const std::vector<double>& effort, const JointColumns& columns,
                   const SmoothJoint& joint, size_t k) {
  if (!effort.empty()) return effort[k];
  if (columns.command.empty()) return std::nan("");
  const double rate = columns.command_rate.empty() ? 0.0 : columns.command_rate[k];
  const double u = calc_servo_effort(laws, columns.command[k] - joint.q[k], rate - joint.qd[k], 0.0);
  return std::max(-laws.effort_limit, std::min(laws.effort_limit, u));
}

// By joint: smallest speed [rad/s] of the samples that are used.
std::vector<double> find_still(const Problem& problem, bool with_gears) {
  std::vector<double> still(static_cast<size_t>(problem.experiment->num_joints()), kSlips);
  for (int r : problem.train) {
    for (size_t j = 0; with_gears && j < still.size(); ++j) {
      // Slower samples still show static friction, which the gear loss would absorb.
      for (double v : problem.smooth[static_cast<size_t>(r)].joints[j].qd)
        still[j] = std::max(still[j], kMinor * std::abs(v));
    }
  }
  return still;
}

void add_recording(const Problem& problem, int r, const std::vector<double>& still, std::vector<Normal>* normals) {
  const Experiment& e = *problem.experiment;
  const Plant plant = make_plant(e, {}, e.recordings[static_cast<size_t>(r)].spec);
  const SmoothRecording& smooth = problem.smooth[static_cast<size_t>(r)];
  Data data(*plant.model);
  State state = make_state(*plant.model);
  Eigen::VectorXd acceleration(e.num_joints()), effort(e.num_joints());
  const Recording& recording = e.recordings[static_cast<size_t>(r)];
  for (size_t k = smooth.start; k < recording.size(); ++k) {
    for (int j = 0; j < e.num_joints(); ++j) {
      const SmoothJoint& joint = smooth.joints[static_cast<size_t>(j)];
      state.q(j) = joint.q[k];
      state.qd(j) = joint.qd[k];
      acceleration(j) = joint.qdd[k];
    }
    update_kinematics(*plant.model, state, &data);
    const LinkWrenches wrenches = calc_wrenches(plant.forces, *plant.model, data);
    calc_inverse_dynamics(*plant.model, acceleration, &wrenches, &data, &effort);
    for (int j = 0; j < e.num_joints(); ++j) {
      const size_t i = static_cast<size_t>(j);
      const double given = find_effort(plant.laws[i], smooth.effort[i], recording.joints[i], smooth.joints[i], k);
      const double missing = given - effort(j), v = state.qd(j);
      if (!std::isfinite(missing) || std::abs(v) < still[i]) continue;
      const double direction = v > 0 ? 1.0 : -1.0, behind = effort(j) * direction < 0 ? -effort(j) : 0.0;
      const Eigen::Vector4d row(v, direction, acceleration(j), behind);
      (*normals)[static_cast<size_t>(j)].gram += row * row.transpose();
      (*normals)[static_cast<size_t>(j)].projection += row * missing;
    }
  }
}

}  // namespace

std::vector<PlainDrive> fit_plain_model(const Problem& problem, bool with_gears) {
  std::vector<Normal> normals(static_cast<size_t>(problem.experiment->num_joints()));
  const std::vector<double> still = find_still(problem, with_gears);
  for (int r : problem.train) add_recording(problem, r, still, &normals);
  std::vector<PlainDrive> fitted;
  for (const Normal& normal : normals) {
    const Eigen::Vector4d x = solve(normal, with_gears);
    fitted.push_back({x[0], x[1], x[2], std::min(kMostHeld, x[3])});
  }
  return fitted;
}

Hypothesis make_plain_model(const std::vector<PlainDrive>& fitted) {
  Hypothesis hypothesis;
  for (size_t i = 0; i < fitted.size(); ++i) {
    const int j = static_cast<int>(i);
    hypothesis.push_back({EffectId::kViscous, j, {fitted[i].viscous}});
    hypothesis.push_back({EffectId::kCoulomb, j, {fitted[i].dry, 0.0, kStick}});
    hypothesis.push_back({EffectId::kRotorInertia, j, {fitted[i].rotor}});
    if (fitted[i].gear > 0.0)
      hypothesis.push_back({find_effect("backdriving_friction")->id, j, {fitted[i].gear, kStick}});
  }
  return hypothesis;
}

}  // namespace hrp::diagnosis
