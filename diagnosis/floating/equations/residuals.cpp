// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/equations/residuals.h"

#include <algorithm>
#include <cmath>

#include "common/multibody/kinematics.h"
#include "diagnosis/data/servo_gains.h"

namespace hrp::diagnosis::floating {
namespace {

// [m] times the weight: a torque [N m] that is smaller hardly holds the teeth of a gear on one side.
constexpr double kSmallTorque = 0.003;

double find_effort(const BodySample& at, size_t joint) {
  double rate = 0;
  if (at.log.has_effort[joint]) return at.clip.effort[joint].value[at.k];
  return at.log.has_law[joint] ? calc_servo_law(at, joint, &rate) : 0.0;
}

}  // namespace

double calc_servo_law(const BodySample& at, size_t j, double* rate) {
  const ServoGains& g = get_servo_gains(at.log.experiment->scenario, at.log.tree.joint(static_cast<int>(j)).name);
  const Track &c = at.clip.command[j], &cd = at.clip.command_rate[j], &q = at.clip.position[j];
  const size_t k = at.k;
  const double speed = cd.empty() ? c.rate[k] : cd.value[k], slope = cd.empty() ? c.second[k] : cd.rate[k];
  *rate = g.kp * speed + g.kd * slope;
  return std::clamp(g.kp * (c.value[k] - q.value[k]) + g.kd * (speed - q.rate[k]), -g.effort_limit, g.effort_limit);
}

BodyResiduals calc_residuals(const BodySample& at, const BodyChannels& channels, const Vector3d& normal) {
  const Model& model = at.motion.model();
  const int n = at.log.num_joints(), base = model.num_base();
  BodyResiduals out;
  out.y = Eigen::VectorXd::Zero(kJointRow + n);
  out.tau.resize(model.nv());
  calc_inverse_dynamics(model, at.motion.vdot(), nullptr, &at.motion.data(), &out.tau);
  for (size_t s = 0; s < at.log.sensors.size(); ++s) {
    project(at, channels, normal, read_wrench(at, static_cast<int>(s)), 1,
            [&](int row, double value) { out.y(row) += value; });
  }
  out.measured = out.y;
  out.load = out.tau.tail(n) - out.y.tail(n);
  for (int j = 0; j < n; ++j) {
    const double effort = channels.joint(j) >= 0 ? find_effort(at, static_cast<size_t>(j)) : 0.0;
    out.measured(kJointRow + j) = effort;
    out.y(kJointRow + j) += effort - out.tau(base + j);
  }
  if (base == 0) return out;
  if (channels.weighs) {
    out.y(kWeightRow) += normal.dot(calc_force_below(at) - out.tau.segment<3>(3));
  } else {
    out.y.head<6>() -= out.tau.head<6>();
    out.y.segment<3>(3) += calc_force_below(at);
  }
  return out;
}

std::vector<JointSides> find_sides(const BodySample& at, const Eigen::VectorXd& load) {
  const double small_torque = kSmallTorque * at.log.mass * at.log.experiment->scenario.gravity_W.norm();
  std::vector<JointSides> sides(static_cast<size_t>(at.log.num_joints()));
  for (int j = 0; j < at.log.num_joints(); ++j) {
    JointSides& s = sides[static_cast<size_t>(j)];
    s.play = 0.5 * std::tanh(load(j) / small_torque);
    s.give = load(j);
    if (!may_bend(at.log, j)) continue;
    const LinkSpec& link = at.log.tree.links[static_cast<size_t>(j) + 1];
    const Matrix3d R = get_pose(at.motion.data(), link.parent).R * link.joint.X_PF.R;
    const Vector3d moment = calc_passed_moment(at, j + 1);
    for (int a = 0; a < 2; ++a) s.bend[a] = moment.dot(R * get_cross_axis(link.joint, 1 + a));
  }
  return sides;
}

}  // namespace hrp::diagnosis::floating
