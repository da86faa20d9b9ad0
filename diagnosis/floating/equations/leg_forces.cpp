// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/equations/leg_forces.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "common/multibody/kinematics.h"
#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis::floating {
namespace {

// What the ground may do to a foot: a force, to a flat sole a moment, too.
int count_directions(const Foot& foot) { return foot.flat ? 6 : 3; }

// [w; v] of the lowest point of a foot by all velocities, base axes.
Eigen::MatrixXd calc_sole_jacobian(const BodySample& at, const Foot& foot) {
  const Model& model = at.motion.model();
  const Vector3d p = get_pose(at.motion.data(), foot.link) * foot.p_LC - foot.radius * at.motion.find_up(at.k);
  Eigen::MatrixXd J(6, model.nv());
  calc_point_jacobian(model, at.motion.data(), foot.link, p, J);
  return J;
}

// Feet without a sensor that may press on the ground within the kernel's reach.
std::vector<const Foot*> list_pressed_feet(const BodySample& at, const Contacts& contacts) {
  std::vector<const Foot*> out;
  const size_t first = at.k > at.clip.edge ? at.k - at.clip.edge : 0;
  const size_t last = std::min(at.k + at.clip.edge, at.clip.size() - 1);
  for (size_t f = 0; f < at.log.feet.size(); ++f) {
    const std::vector<char>& loaded = contacts.loaded[at.clip_index][f];
    const bool pressed = loaded[first] || loaded[at.k] || loaded[last];
    if (pressed && !is_known(at.log, at.log.feet[f])) out.push_back(&at.log.feet[f]);
  }
  return out;
}

// [m] Of a leg that stands straight, from the base to the foot.
double find_reach(const BodySample& at, const Foot& foot) { return get_pose(at.motion.data(), foot.link).p.norm(); }

}  // namespace

Eigen::MatrixXd calc_share_of_base(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, double reach) {
  if (A.rows() < A.cols()) return {};
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> squares(A.transpose() * A);
  // A lever of a tenth of the leg: an error of a torque is ten times as large in the force.
  if (squares.eigenvalues()(0) < std::pow(kDetail * reach, 2)) return {};
  const Eigen::MatrixXd& V = squares.eigenvectors();
  return B * V * squares.eigenvalues().cwiseInverse().asDiagonal() * V.transpose() * A.transpose();
}

std::vector<char> list_legs_that_tell(const LeggedLog& log) {
  std::vector<char> out(static_cast<size_t>(log.num_joints()), 0);
  for (const Foot& foot : log.feet) {
    if (is_known(log, foot)) continue;
    int joints = 0;
    for (int l = foot.link; l > 0; l = log.tree.links[static_cast<size_t>(l)].parent) {
      const auto j = static_cast<size_t>(l - 1);
      if (log.tree.joint(l - 1).actuated && !(log.has_effort[j] && log.has_position[j])) return {};
      if (out[j]) return {};  // two feet in one torque
      out[j] = 1;
      ++joints;
    }
    if (joints < count_directions(foot)) return {};
  }
  return out;
}

Eigen::MatrixXd find_leg_shares(const BodySample& at, const Contacts& contacts) {
  const int n = at.log.num_joints();
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(6, n);
  for (const Foot* foot : list_pressed_feet(at, contacts)) {
    const Eigen::MatrixXd Jt = calc_sole_jacobian(at, *foot).bottomRows(count_directions(*foot)).transpose();
    const Eigen::MatrixXd share = calc_share_of_base(Jt.bottomRows(n), Jt.topRows(6), find_reach(at, *foot));
    if (share.size() == 0) return {};
    out += share;
  }
  return out;
}

}  // namespace hrp::diagnosis::floating
