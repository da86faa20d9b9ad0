// SPDX-License-Identifier: BSD-3-Clause
#include "controller/walking/whole_body.h"

#include <algorithm>
#include <cmath>

#include "common/base/diagnostics.h"
#include "common/multibody/momentum.h"
#include "common/robot/sole.h"
#include "common/spatial/turn_z.h"

namespace hrp::walking {
namespace {

[[noreturn]] void refuse(const std::string& field, const std::string& message) {
  refuse_input({"", "controller.walk." + field}, message);
}

bool is_near(const Vector3d& a, const Vector3d& b) { return (a - b).cwiseAbs().maxCoeff() < 1e-9; }

}  // namespace

WholeBody::WholeBody(const RobotDescription& robot, const WalkSpec& spec, const Eigen::VectorXd& rest)
    : model_(robot.tree), data_(model_), state_(make_state(model_)), J_(6, model_.nv()) {
  update_kinematics(model_, state_, &data_);  // straight: axes of the soles
  legs_[kLeft] = make_leg(robot, spec.left_foot);
  legs_[kRight] = make_leg(robot, spec.right_foot);
  update(rest);
}

WholeBody::Leg WholeBody::make_leg(const RobotDescription& robot, const std::string& foot) {
  const int frame = robot.tree.find_frame(foot);
  if (frame < 0) refuse("left_foot", "the robot has no link '" + foot + "'");
  Leg leg;
  leg.foot = robot.tree.frames[static_cast<size_t>(frame)].link;
  int link = leg.foot;
  for (int i = 5; i >= 0; --i) {
    if (link == 0) refuse("left_foot", "'" + foot + "' has fewer than six joints to the base");
    leg.links[i] = link;
    leg.signs[i] = 1.0;
    link = robot.tree.links[static_cast<size_t>(link)].parent;
  }
  if (link != 0) refuse("left_foot", "'" + foot + "' has more than six joints to the base");
  const Transform X_BL = get_pose(data_, leg.foot);
  leg.X_LS.R = X_BL.R.transpose();
  bool found = false;
  for (const Sole& sole : make_soles(robot)) {
    if (!model_.is_ancestor(leg.foot, sole.link)) continue;
    leg.X_LS.p = X_BL.inverse() * (get_pose(data_, sole.link) * sole.p_LR);
    found = true;
  }
  if (!found) refuse("left_foot", "'" + foot + "' has no sole");
  recognise(robot.tree, &leg);
  return leg;
}

// Legs of HRP's kind have a closed form.
void WholeBody::recognise(const TreeSpec& tree, Leg* leg) const {
  const Vector3d axes[6] = {Vector3d::UnitZ(), Vector3d::UnitX(), Vector3d::UnitY(),
                            Vector3d::UnitY(), Vector3d::UnitY(), Vector3d::UnitX()};
  Vector3d p[6];
  for (int i = 0; i < 6; ++i) {
    const JointSpec& joint = tree.links[static_cast<size_t>(leg->links[i])].joint;
    if (joint.kind != JointKind::kRevolute || !joint.X_PF.R.isIdentity(1e-9)) return;
    if (!is_near(joint.axis_F, axes[i]) && !is_near(joint.axis_F, -axes[i])) return;
    leg->signs[i] = joint.axis_F.dot(axes[i]) > 0.0 ? 1.0 : -1.0;
    p[i] = joint.X_PF.p;
  }
  if (!p[1].isZero(1e-9) || !p[2].isZero(1e-9) || !p[5].isZero(1e-9)) return;
  if (p[3].head<2>().norm() > 1e-9 || std::abs(p[4].x()) > 1e-9) return;
  leg->p_BH = p[0];
  leg->geometry = {-p[3].z(), -p[4].z(), p[4].y()};
  leg->closed_form = true;
}

void WholeBody::update(const Eigen::VectorXd& q) {
  for (int i = 0; i < model_.num_joints(); ++i) state_.q[i] = model_.spec().joint(i).actuated ? q[i] : 0.0;
  update_kinematics(model_, state_, &data_);
}

Transform WholeBody::get_sole(Side side) const { return get_pose(data_, legs_[side].foot) * legs_[side].X_LS; }
Vector3d WholeBody::get_com() const { return calc_centre_of_mass(model_, data_); }
Transform WholeBody::get_frame(int frame) const { return calc_frame_pose(model_, data_, frame); }

bool WholeBody::solve_closed(const Leg& leg, const Transform& X_BF) {
  const auto angles = solve_leg(leg.geometry, {X_BF.R, X_BF.p - leg.p_BH});
  if (!angles) return false;
  for (int i = 0; i < 6; ++i) state_.q[leg.links[i] - 1] = leg.signs[i] * (*angles)[i];
  return true;
}

// Newton's method with a little damping, from the angles of the last solution; other joint orders than HRP's.
bool WholeBody::solve_numerically(const Leg& leg, const Transform& X_BF) {
  constexpr double kGood = 1e-9, kDamping = 1e-8, kLargestStep = 0.2;
  const Eigen::VectorXd before = state_.q;
  for (int iteration = 0; iteration < 50; ++iteration) {
    update_kinematics(model_, state_, &data_);
    const Transform now = get_pose(data_, leg.foot);
    const Eigen::AngleAxisd turn(X_BF.R * now.R.transpose());
    Vector6d error;
    error << turn.angle() * turn.axis(), X_BF.p - now.p;
    if (error.cwiseAbs().maxCoeff() < kGood) return true;
    calc_point_jacobian(model_, data_, leg.foot, now.p, J_);
    Matrix6d J;
    for (int i = 0; i < 6; ++i) J.col(i) = J_.col(model_.velocity_index(leg.links[i]));
    Vector6d dq = J.transpose() * (J * J.transpose() + kDamping * Matrix6d::Identity()).ldlt().solve(error);
    dq *= std::min(1.0, kLargestStep / std::max(dq.cwiseAbs().maxCoeff(), 1e-12));
    for (int i = 0; i < 6; ++i) state_.q[leg.links[i] - 1] += dq[i];
  }
  state_.q = before;
  return false;
}

bool WholeBody::solve(const Vector3d& com, const Matrix3d& R_WB, const Transform soles[2], Eigen::VectorXd* q) {
  constexpr double kGood = 1e-6;
  bool reached = true;
  for (int iteration = 0; iteration < 8 && reached; ++iteration) {
    const Transform X_WB{R_WB, com - R_WB * get_com()};
    for (int side : {kLeft, kRight}) {
      const Leg& leg = legs_[side];
      const Transform X_BF = X_WB.inverse() * soles[side] * leg.X_LS.inverse();
      reached = (leg.closed_form ? solve_closed(leg, X_BF) : solve_numerically(leg, X_BF)) && reached;
    }
    update_kinematics(model_, state_, &data_);
    if ((X_WB * get_com() - com).norm() < kGood) break;
  }
  *q = state_.q;
  return reached;
}

Matrix3d calc_pattern_axes(const WholeBody& body, const Matrix3d& R_WB) {
  const Vector3d forward = R_WB * (body.get_sole(kLeft).R.col(0) + body.get_sole(kRight).R.col(0));
  return turn_z(-std::atan2(forward.y(), forward.x()));
}

PatternStart make_pattern_start(const WholeBody& body, const Matrix3d& R_PB) {
  const Transform soles_B[2] = {body.get_sole(kLeft), body.get_sole(kRight)};
  const Vector3d middle = 0.5 * (R_PB * soles_B[kLeft].p + R_PB * soles_B[kRight].p);
  PatternStart start;
  start.com = R_PB * body.get_com() - middle;
  start.R_WB = R_PB;
  for (int side : {kLeft, kRight}) start.soles[side] = {R_PB * soles_B[side].R, R_PB * soles_B[side].p - middle};
  return start;
}

}  // namespace hrp::walking
