// SPDX-License-Identifier: BSD-3-Clause
// The algorithms of common/multibody against each other: four ways to the same numbers.
#include <gtest/gtest.h>

#include "common/multibody/forward_dynamics.h"
#include "common/multibody/mass_matrix.h"
#include "common/multibody/momentum.h"
#include "tests/unit/multibody/random_tree.h"

namespace hrp {
namespace {

using testing::Random;
using testing::relative_error;

// Rounding of two O(n) recursions over at most 30 links; the bound for our own algorithms against each other.
constexpr double kTolerance = 1e-11;

class Trees : public ::testing::TestWithParam<int> {
 protected:
  Trees()
      : random(static_cast<unsigned>(GetParam()) + 100),
        model(testing::make_random_tree(static_cast<unsigned>(GetParam()), 1 + GetParam() % 30, GetParam() % 2 == 0)),
        data(model),
        state(testing::make_random_state(model, &random)) {
    update_kinematics(model, state, &data);
  }
  LinkWrenches make_wrenches() {
    LinkWrenches wrenches;
    for (int i = 0; i < model.num_links(); ++i) {
      wrenches.emplace_back();
      wrenches.back() << random.vector(10), random.vector(50);
    }
    return wrenches;
  }
  Eigen::VectorXd calc_tau(const Eigen::VectorXd& vdot, const LinkWrenches* wrenches) {
    Eigen::VectorXd tau(model.nv());
    calc_inverse_dynamics(model, vdot, wrenches, &data, &tau);
    return tau;
  }
  Eigen::MatrixXd calc_link_jacobian(int link) {
    Eigen::MatrixXd J(6, model.nv());
    calc_point_jacobian(model, data, link, get_pose(data, link).p, J);
    return J;
  }

  Random random;
  Model model;
  Data data;
  State state;
};

TEST_P(Trees, ForwardDynamicsUndoesInverseDynamics) {
  const LinkWrenches wrenches = make_wrenches();
  const Eigen::VectorXd vdot = random.values(model.nv(), 10);
  LinkWrenches all = wrenches;
  const Eigen::VectorXd tau = calc_tau(vdot, &wrenches);
  if (model.floating()) all[0] += tau.head<6>();
  Eigen::VectorXd result(model.nv());
  ASSERT_EQ(calc_forward_dynamics(model, tau.tail(model.num_joints()), &all, {}, &data, &result), Status::kOk);
  EXPECT_LT(relative_error(result, vdot), kTolerance);
}

TEST_P(Trees, ColumnsOfTheMassMatrixAreInverseDynamicsOfUnitAccelerations) {
  const Eigen::MatrixXd M = update_mass_matrix(model, &data);
  Eigen::VectorXd bias(model.nv());
  calc_bias(model, &data, &bias);
  for (int j = 0; j < model.nv(); ++j) {
    const Eigen::VectorXd column = calc_tau(Eigen::VectorXd::Unit(model.nv(), j), nullptr) - bias;
    // The bias cancels in the difference, so rounding is relative to it too.
    EXPECT_LT((column - M.col(j)).norm(), kTolerance * (M.col(j).norm() + bias.norm())) << "column " << j;
  }
}

TEST_P(Trees, ForwardDynamicsEqualsTheDenseSolve) {
  const LinkWrenches wrenches = make_wrenches();
  const Eigen::VectorXd effort = random.values(model.num_joints(), 20);
  const Eigen::MatrixXd M = update_mass_matrix(model, &data);
  Eigen::VectorXd right = -calc_tau(Eigen::VectorXd::Zero(model.nv()), &wrenches);
  right.tail(model.num_joints()) += effort;
  Eigen::VectorXd vdot(model.nv());
  ASSERT_EQ(calc_forward_dynamics(model, effort, &wrenches, {}, &data, &vdot), Status::kOk);
  EXPECT_LT(relative_error(M * vdot, right), kTolerance);
  EXPECT_LT(relative_error(vdot, M.ldlt().solve(right)), kTolerance);
}

TEST_P(Trees, ImpedancesAndExtraInertiaEqualTheDenseSolve) {
  const LinkWrenches wrenches = make_wrenches();
  const Eigen::VectorXd effort = random.values(model.num_joints(), 20);
  const Eigen::VectorXd extra = random.values(model.num_joints(), 1).cwiseAbs();
  LinkImpedances impedances(2);
  for (LinkImpedance& impedance : impedances) {
    impedance.link = random.index(model.num_links());
    const Eigen::MatrixXd B = random.values(36, 3).reshaped(6, 6);
    impedance.Z = B * B.transpose();
  }
  Eigen::VectorXd vdot(model.nv());
  ASSERT_EQ(calc_forward_dynamics(model, effort, &wrenches, {&extra, &impedances}, &data, &vdot), Status::kOk);

  Eigen::MatrixXd A = update_mass_matrix(model, &data);
  A.diagonal().tail(model.num_joints()) += extra;
  Eigen::VectorXd right = -calc_tau(Eigen::VectorXd::Zero(model.nv()), &wrenches);
  right.tail(model.num_joints()) += effort;
  for (const LinkImpedance& impedance : impedances) {
    const Eigen::MatrixXd J = calc_link_jacobian(impedance.link);
    A += J.transpose() * impedance.Z * J;
    right -= J.transpose() * impedance.Z *
             calc_point_bias_acceleration(model, impedance.link, get_pose(data, impedance.link).p, &data);
  }
  EXPECT_LT(relative_error(A * vdot, right), kTolerance);
}

// The contacts of a step switch between its solves: only the loaded links are gathered again.
TEST_P(Trees, OnlyWhatChangedAgainGivesTheSameBits) {
  LinkWrenches wrenches = make_wrenches();
  const Eigen::VectorXd effort = random.values(model.num_joints(), 20);
  const Eigen::VectorXd extra = random.values(model.num_joints(), 1).cwiseAbs();
  LinkImpedances impedances(1);
  impedances[0].link = random.index(model.num_links());
  const int pushed = random.index(model.num_links());
  std::vector<char> marks(static_cast<size_t>(model.num_links()), 0);
  for (const int link : {impedances[0].link, pushed}) mark_path(model, link, &marks);
  Eigen::VectorXd vdot(model.nv()), again(model.nv());
  ASSERT_EQ(calc_forward_dynamics(model, effort, &wrenches, {&extra, &impedances}, &data, &again), Status::kOk);
  for (int round = 0; round < 3; ++round) {
    const Eigen::MatrixXd B = random.values(36, 3).reshaped(6, 6);
    impedances[0].Z = B * B.transpose();
    wrenches[static_cast<size_t>(pushed)] *= -1.5;
    const ImplicitTerms implicit{&extra, &impedances};
    ASSERT_EQ(recalc_forward_dynamics(model, marks, effort, &wrenches, implicit, &data, &again), Status::kOk);
    Data fresh = data;
    ASSERT_EQ(calc_forward_dynamics(model, effort, &wrenches, implicit, &fresh, &vdot), Status::kOk);
    EXPECT_EQ(again, vdot);
  }
}

TEST_P(Trees, ResponsesSolveWithTheMassMatrix) {
  Eigen::VectorXd vdot(model.nv());
  ASSERT_EQ(calc_forward_dynamics(model, Eigen::VectorXd::Zero(model.num_joints()), nullptr, {}, &data, &vdot),
            Status::kOk);
  const Eigen::MatrixXd B = random.values(3 * model.nv(), 5).reshaped(model.nv(), 3);
  Eigen::MatrixXd X(model.nv(), 3);
  calc_responses(model, B, &data, &X);
  EXPECT_LT(relative_error(update_mass_matrix(model, &data) * X, B), kTolerance);
}

TEST_P(Trees, WrenchesActThroughTheTransposedJacobian) {
  const LinkWrenches wrenches = make_wrenches();
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(model.nv());
  Eigen::VectorXd expected = calc_tau(zero, nullptr);
  for (int i = 0; i < model.num_links(); ++i) {
    expected -= calc_link_jacobian(i).transpose() * wrenches[static_cast<size_t>(i)];
  }
  EXPECT_LT(relative_error(calc_tau(zero, &wrenches), expected), kTolerance);
}

INSTANTIATE_TEST_SUITE_P(Seeds, Trees, ::testing::Range(0, 40));

}  // namespace
}  // namespace hrp
