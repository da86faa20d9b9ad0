// SPDX-License-Identifier: BSD-3-Clause
#include "common/multibody/loops.h"

#include <gtest/gtest.h>

#include "common/multibody/kinematics.h"
#include "common/multibody/mass_matrix.h"
#include "common/multibody/momentum.h"
#include "tests/unit/multibody/random_tree.h"

namespace hrp {
namespace {

using testing::Random;
using testing::relative_error;

LinkSpec make_bar(const std::string& name, int parent, const Vector3d& p_PF, double length) {
  LinkSpec link;
  link.name = name;
  link.parent = parent;
  link.inertia.mass = length;
  link.inertia.p_LLcm_L = Vector3d(length / 2, 0, 0);
  link.inertia.I_LLcm_L = Vector3d(1e-4, length * length * length / 12, length * length * length / 12).asDiagonal();
  link.joint.name = name + "_joint";
  link.joint.X_PF.p = p_PF;
  link.joint.axis_F = Vector3d::UnitY();
  return link;
}

// A parallelogram: crank, coupler and rocker of length 1, 2, 1 on a ground of length 2. It moves with equal angles.
TreeSpec make_parallelogram() {
  TreeSpec spec;
  spec.name = "parallelogram";
  spec.floating_base = false;
  spec.links.push_back(LinkSpec{"ground", -1, {}, {}});
  spec.links.push_back(make_bar("crank", 0, Vector3d::Zero(), 1));
  spec.links.push_back(make_bar("coupler", 1, Vector3d(1, 0, 0), 2));
  spec.links.push_back(make_bar("rocker", 0, Vector3d(2, 0, 0), 1));
  return spec;
}

LoopConstraint make_pin() {
  LoopConstraint pin;
  pin.kind = LoopKind::kPin;
  pin.link_a = 2;
  pin.link_b = 3;
  pin.X_AF.p = Vector3d(2, 0, 0);
  pin.X_BF.p = Vector3d(1, 0, 0);
  pin.X_AF.R = pin.X_BF.R = make_rotation_from_rpy(Vector3d(-M_PI / 2, 0, 0));  // z along the joint axes
  return pin;
}

TEST(Loops, AParallelogramMovesAsOneDegreeOfFreedom) {
  const Model model(make_parallelogram());
  Data data(model);
  Loops loops(model, {make_pin()});
  State state = make_state(model);
  const double angle = 0.7, rate = 1.5;
  state.q << angle, -angle, angle;
  state.qd << rate, -rate, rate;
  update_kinematics(model, state, &data);
  Eigen::VectorXd vdot(3);
  ASSERT_EQ(loops.calc_forward_dynamics(model, state, Eigen::VectorXd::Zero(3), nullptr, {}, &data, &vdot),
            Status::kOk);
  EXPECT_LT(loops.position_error().norm(), 1e-15);
  EXPECT_LT(loops.velocity_error().norm(), 1e-15);
  // Crank and rocker turn (1/3 m l^2 each), the coupler (mass 2) moves on a circle of radius 1. Rotation about +y takes
  // x towards -z, so gravity torque at angle a: (1/2 + 2 + 1/2) 9.81 cos a.
  const double inertia = 1.0 / 3 + 1.0 / 3 + 2.0, torque = 3 * 9.81 * std::cos(angle);
  // Five equations of which two suffice: G is singular and regularised by 1e-12.
  EXPECT_NEAR(vdot[0], torque / inertia, 1e-8);
  EXPECT_NEAR(vdot[1], -torque / inertia, 1e-8);
  EXPECT_NEAR(vdot[2], torque / inertia, 1e-8);
}

TEST(Loops, HoldOverASwing) {
  const Model model(make_parallelogram());
  Data data(model);
  Loops loops(model, {make_pin()});
  State state = make_state(model);
  state.q << 0.7, -0.7, 0.7;
  Eigen::VectorXd vdot(3), v(3);
  double worst = 0;
  for (int i = 0; i < 2000; ++i) {
    update_kinematics(model, state, &data);
    ASSERT_EQ(loops.calc_forward_dynamics(model, state, Eigen::VectorXd::Zero(3), nullptr, {}, &data, &vdot),
              Status::kOk);
    worst = std::max(worst, loops.position_error().norm());
    state.qd += 1e-3 * vdot;
    get_generalised_velocity(model, state, &v);
    integrate_positions(model, v, 1e-3, &state);
  }
  EXPECT_LT(worst, 1e-3);  // first-order integrator at 1 ms on bars of 1 m, drift pulled back
  EXPECT_LT(loops.position_error().norm(), 1e-3);
}

class Welds : public ::testing::TestWithParam<int> {};

TEST_P(Welds, EqualTheDenseSaddlePointSolution) {
  const Model model(testing::make_random_tree(static_cast<unsigned>(GetParam()), 14, true));
  Random random(5);
  Data data(model);
  const State state = testing::make_random_state(model, &random);
  LoopConstraint weld;
  weld.kind = LoopKind::kWeld;
  weld.link_a = 14;
  weld.X_AF = {random.rotation(), random.vector(0.1)};
  weld.X_BF = {random.rotation(), random.vector(0.1)};
  Loops loops(model, {weld});
  loops.set_stabilisation(0, 0);
  update_kinematics(model, state, &data);
  const Eigen::VectorXd effort = random.values(14, 10);
  Eigen::VectorXd vdot(model.nv()), free(model.nv());
  ASSERT_EQ(loops.calc_forward_dynamics(model, state, effort, nullptr, {}, &data, &vdot), Status::kOk);
  // M (vdot - free) = J^T lambda for the same lambda, and the weld has no acceleration along its rows.
  ASSERT_EQ(calc_forward_dynamics(model, effort, nullptr, {}, &data, &free), Status::kOk);
  EXPECT_LT(relative_error(update_mass_matrix(model, &data) * (vdot - free),
                           loops.jacobian().transpose() * loops.multipliers()),
            1e-10);
  update_accelerations(model, vdot, &data);
  const Vector6d A = calc_point_acceleration(data, 14, get_pose(data, 14) * weld.X_AF.p);
  EXPECT_LT(A.norm(), 1e-7 * free.norm());  // the regularisation of 1e-12 times condition numbers up to 1e4
}

INSTANTIATE_TEST_SUITE_P(Seeds, Welds, ::testing::Range(0, 8));

TEST(Loops, CoupledJointsKeepTheirRatio) {
  const Model model(testing::make_random_tree(4, 6, false));
  Random random(2);
  Data data(model);
  State state = testing::make_random_state(model, &random);
  LoopConstraint coupling;
  coupling.kind = LoopKind::kCoupling;
  coupling.joint_a = 5;
  coupling.joint_b = 2;
  coupling.ratio = -0.5;
  coupling.offset = state.q[5] + 0.5 * state.q[2];
  state.qd[5] = -0.5 * state.qd[2];
  Loops loops(model, {coupling});
  update_kinematics(model, state, &data);
  Eigen::VectorXd vdot(model.nv());
  ASSERT_EQ(loops.calc_forward_dynamics(model, state, random.values(6, 5), nullptr, {}, &data, &vdot), Status::kOk);
  EXPECT_NEAR(vdot[5], -0.5 * vdot[2], 1e-9 * vdot.norm());
}

}  // namespace
}  // namespace hrp
