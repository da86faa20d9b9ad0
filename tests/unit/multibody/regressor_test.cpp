// SPDX-License-Identifier: BSD-3-Clause
#include "common/multibody/regressor.h"

#include <gtest/gtest.h>

#include "common/multibody/base_parameters.h"
#include "common/multibody/inverse_dynamics.h"
#include "common/multibody/kinematics.h"
#include "tests/unit/multibody/random_tree.h"

namespace hrp {
namespace {

using testing::Random;
using testing::relative_error;

TreeSpec make_tree(int seed, int joints, bool floating) {
  TreeSpec spec = testing::make_random_tree(static_cast<unsigned>(seed), joints, floating);
  for (int i = 0; i < spec.num_joints(); ++i) {
    spec.joint(i).viscous_friction = 0.1 + 0.01 * i;
    spec.joint(i).coulomb_friction = 0.3 + 0.02 * i;
  }
  return spec;
}

struct Sample {
  Sample(const Model& model, Random* random) : data(model), regressor(model), tau(model.nv()) {
    state = testing::make_random_state(model, random);
    if (!model.floating()) state.R_WB.setIdentity();  // as calc_base_parameters takes a fixed base to stand
    const Eigen::VectorXd vdot = random->values(model.nv(), 10);
    update_kinematics(model, state, &data);
    calc_inverse_dynamics(model, vdot, nullptr, &data, &tau);
    base_wrench = get_joint_wrench(data, 0);
    calc_regressor(model, vdot, &data, &regressor);
    for (int i = 0; i < model.num_joints(); ++i) {
      const JointSpec& joint = model.spec().joint(i);
      const double qd = state.qd[i];
      tau[model.num_base() + i] += joint.viscous_friction * qd + joint.coulomb_friction * (qd > 0 ? 1 : -1);
    }
  }
  State state;
  Data data;
  Regressor regressor;
  Vector6d base_wrench;
  Eigen::VectorXd tau;
};

class Regressors : public ::testing::TestWithParam<int> {};

TEST_P(Regressors, TimesParametersAreInverseDynamicsWithFriction) {
  const Model model(make_tree(GetParam(), 15, GetParam() % 2 == 0));
  Random random(9);
  const Sample s(model, &random);
  const Eigen::VectorXd phi_I = make_inertial_parameters(model), phi_J = make_joint_parameters(model);
  EXPECT_LT(relative_error(s.regressor.Y_BI * phi_I, s.base_wrench), 1e-11);
  EXPECT_LT(relative_error(s.regressor.Y_JI * phi_I + s.regressor.Y_JJ * phi_J, s.tau.tail(model.num_joints())), 1e-11);
}

TEST_P(Regressors, BaseParametersReproduceBaseWrenchAndEfforts) {
  const Model model(make_tree(GetParam(), 6, GetParam() % 2 == 0));
  const BaseParameters base = calc_base_parameters(model, RegressorRows::kAll);
  const Eigen::VectorXd phi = make_inertial_parameters(model), phi_base = base.T * phi;
  EXPECT_GT(base.dependent.size(), 0u);
  Random random(11);
  for (int i = 0; i < 5; ++i) {
    const Sample s(model, &random);
    // The grouping is a least-squares solution with condition numbers around 1e3.
    EXPECT_LT(relative_error(get_independent_columns(base, s.regressor.Y_BI) * phi_base, s.regressor.Y_BI * phi), 1e-9);
    EXPECT_LT(relative_error(get_independent_columns(base, s.regressor.Y_JI) * phi_base, s.regressor.Y_JI * phi), 1e-9);
  }
}

TEST_P(Regressors, TheBaseLinkAloneShowsAllBaseParametersOfAFloatingTree) {
  const Model model(make_tree(GetParam(), 6, true));
  EXPECT_EQ(calc_base_parameters(model, RegressorRows::kBase).independent,
            calc_base_parameters(model, RegressorRows::kAll).independent);
}

INSTANTIATE_TEST_SUITE_P(Seeds, Regressors, ::testing::Range(0, 8));

TEST(BaseParameterCount, IsTenAndSevenPerTurningJointOfAFloatingTree) {
  TreeSpec spec = make_tree(1, 5, true);
  for (int i = 0; i < 5; ++i) spec.joint(i).kind = JointKind::kRevolute;
  const BaseParameters base = calc_base_parameters(Model(spec), RegressorRows::kAll);
  EXPECT_EQ(base.independent.size(), 10u + 7u * 5u);
}

TEST(BaseParameterCount, OfAPendulumInGravityIsThree) {
  TreeSpec spec = make_tree(1, 1, false);
  spec.joint(0) = JointSpec{};
  spec.joint(0).name = "swing";
  spec.joint(0).axis_F = Vector3d::UnitY();
  const BaseParameters base = calc_base_parameters(Model(spec), RegressorRows::kJoints);
  EXPECT_EQ(base.independent, (std::vector<int>{11, 13, 17}));  // m cx, m cz, Iyy of the moving link
}

}  // namespace
}  // namespace hrp
