// SPDX-License-Identifier: BSD-3-Clause
#include "common/multibody/kinematics.h"

#include <gtest/gtest.h>

#include "common/multibody/inverse_dynamics.h"
#include "common/multibody/mass_matrix.h"
#include "common/multibody/momentum.h"
#include "tests/unit/multibody/random_tree.h"

namespace hrp {
namespace {

using testing::Random;
using testing::relative_error;

// Central differences with h = 1e-5: truncation h^2 (1e-10 relative to third derivatives of up to 100) and rounding
// 1e-16 / h = 1e-11.
constexpr double kStep = 1e-5;
constexpr double kDifference = 1e-6;

class Motion : public ::testing::TestWithParam<int> {
 protected:
  Motion()
      : random(static_cast<unsigned>(GetParam())),
        model(testing::make_random_tree(static_cast<unsigned>(GetParam()) + 50, 12, GetParam() % 2 == 0)),
        data(model),
        state(testing::make_random_state(model, &random)),
        v(model.nv()),
        vdot(random.values(model.nv(), 5)) {
    get_generalised_velocity(model, state, &v);
    update_kinematics(model, state, &data);
  }
  // The state after dt of motion with constant vdot.
  State move(double dt) const {
    State moved = state;
    integrate_positions(model, v + 0.5 * dt * vdot, dt, &moved);
    set_generalised_velocity(model, v + dt * vdot, &moved);
    return moved;
  }
  template <class Function>
  auto differentiate(Function function) {
    Data before(model), after(model);
    update_kinematics(model, move(-kStep), &before);
    update_kinematics(model, move(kStep), &after);
    return ((function(after) - function(before)) / (2 * kStep)).eval();
  }

  Random random;
  Model model;
  Data data;
  State state;
  Eigen::VectorXd v, vdot;
};

TEST_P(Motion, VelocityOfAFrameIsTheDerivativeOfItsPose) {
  const Vector6d V = calc_frame_velocity(model, data, 0);
  const Vector3d v_WF = differentiate([this](const Data& d) { return calc_frame_pose(model, d, 0).p; });
  const Matrix3d Rdot = differentiate([this](const Data& d) { return calc_frame_pose(model, d, 0).R; });
  EXPECT_LT(relative_error(v_WF, V.tail<3>()), kDifference);
  EXPECT_LT(relative_error(Rdot, skew(V.head<3>()) * calc_frame_pose(model, data, 0).R), kDifference);
}

TEST_P(Motion, JacobianTimesVelocityIsTheFrameVelocity) {
  Eigen::MatrixXd J(6, model.nv());
  calc_frame_jacobian(model, data, 0, J);
  EXPECT_LT(relative_error(J * v, calc_frame_velocity(model, data, 0)), 1e-13);
}

TEST_P(Motion, AccelerationOfAFrameIsTheDerivativeOfItsVelocity) {
  update_accelerations(model, vdot, &data);
  const Vector6d A = calc_frame_acceleration(model, data, 0);
  const Vector6d dV = differentiate([this](const Data& d) { return calc_frame_velocity(model, d, 0); });
  EXPECT_LT(relative_error(dV, A), kDifference);
}

TEST_P(Motion, AccelerationIsJacobianTimesVdotPlusBias) {
  const Vector3d p = calc_frame_pose(model, data, 0).p;
  Eigen::MatrixXd J(6, model.nv());
  calc_frame_jacobian(model, data, 0, J);
  const Vector6d bias = calc_point_bias_acceleration(model, model.num_links() - 1, p, &data);
  update_accelerations(model, vdot, &data);
  EXPECT_LT(relative_error(J * vdot + bias, calc_frame_acceleration(model, data, 0)), 1e-12);
}

TEST_P(Motion, CentreOfMassMovesWithItsJacobian) {
  Eigen::MatrixXd J(3, model.nv());
  calc_centre_of_mass_jacobian(model, &data, J);
  const Vector3d velocity = calc_centre_of_mass_velocity(model, data);
  EXPECT_LT(relative_error(J * v, velocity), 1e-12);
  EXPECT_LT(relative_error(differentiate([this](const Data& d) { return calc_centre_of_mass(model, d); }), velocity),
            kDifference);
}

TEST_P(Motion, KineticEnergyIsHalfOfVTimesMTimesV) {
  EXPECT_NEAR(calc_kinetic_energy(model, data), 0.5 * v.dot(update_mass_matrix(model, &data) * v),
              1e-12 * calc_kinetic_energy(model, data));
}

TEST_P(Motion, PowerOfTheEffortsIsTheChangeOfEnergy) {
  Eigen::VectorXd tau(model.nv());
  calc_inverse_dynamics(model, vdot, nullptr, &data, &tau);
  const auto energy = [this](const Data& d) {
    return Eigen::Matrix<double, 1, 1>(calc_kinetic_energy(model, d) + calc_potential_energy(model, d));
  };
  EXPECT_NEAR(differentiate(energy)(0), tau.dot(v), kDifference * tau.norm() * v.norm());
}

TEST_P(Motion, MomentumChangesByWeightAndTheBaseWrench) {
  if (!model.floating()) GTEST_SKIP() << "a fixed base takes up momentum";
  Eigen::VectorXd tau(model.nv());
  calc_inverse_dynamics(model, vdot, nullptr, &data, &tau);
  const Vector6d change = differentiate([this](const Data& d) { return calc_momentum(model, d, Vector3d::Zero()); });
  const Vector3d weight = model.mass() * model.gravity_W();
  Vector6d applied = tau.head<6>();
  applied.head<3>() += state.p_WB.cross(Vector3d(tau.segment<3>(3))) + calc_centre_of_mass(model, data).cross(weight);
  applied.tail<3>() += weight;
  EXPECT_LT((change - applied).norm(), kDifference * applied.norm());
}

TEST_P(Motion, CentroidalMomentumIsThatOfTheMassMatrixShiftedToTheCentreOfMass) {
  if (!model.floating()) GTEST_SKIP() << "needs the base's rows";
  const Vector6d about_base = update_mass_matrix(model, &data).topRows<6>() * v;
  Vector6d expected = about_base;
  expected.head<3>() += (state.p_WB - calc_centre_of_mass(model, data)).cross(Vector3d(about_base.tail<3>()));
  EXPECT_LT(relative_error(calc_centroidal_momentum(model, data), expected), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Seeds, Motion, ::testing::Range(0, 10));

TEST(StateHash, DiffersWithTheLastBitOfAnyNumber) {
  const Model model(testing::make_random_tree(3, 4, true));
  Random random(1);
  const State state = testing::make_random_state(model, &random);
  State other = state;
  EXPECT_EQ(calc_state_hash(state), calc_state_hash(other));
  other.qd[3] = std::nextafter(other.qd[3], 10.0);
  EXPECT_NE(calc_state_hash(state), calc_state_hash(other));
}

TEST(Integration, TurnsAtConstantRateExactly) {
  const Model model(testing::make_random_tree(3, 1, true));
  State state = make_state(model);
  Eigen::VectorXd v = Eigen::VectorXd::Zero(7);
  v.head<3>() = Vector3d(0.3, -0.4, 1.2);  // 1.3 rad/s
  for (int i = 0; i < 1000; ++i) integrate_positions(model, v, 0.01, &state);
  const Eigen::Quaterniond exact(Eigen::AngleAxisd(13.0, Vector3d(0.3, -0.4, 1.2) / 1.3));
  EXPECT_LT(state.R_WB.angularDistance(exact), 1e-7);  // acos near 1 shows rounding of 1e-15 as 5e-8
}

}  // namespace
}  // namespace hrp
