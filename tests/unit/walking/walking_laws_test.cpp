// SPDX-License-Identifier: BSD-3-Clause
// Inverse kinematics with the whole body's centre of mass, estimates from sensors, laws of the stabilizer.
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "common/robot/scenario.h"
#include "controller/walking/estimate.h"
#include "controller/walking/stabilizer.h"
#include "controller/walking/whole_body.h"
#include "servers/model_parser/robot_loader.h"
#include "tests/test_places.h"

namespace hrp::walking {
namespace {

struct Body {
  Scenario scenario;
  RobotDescription robot;
  Eigen::VectorXd rest;
  WalkSpec spec;
  explicit Body(const std::string& file)
      : scenario(load_scenario(source_dir() + "/models/scenarios/" + file)), robot(load_robot(scenario)) {
    rest.setZero(robot.tree.num_joints());
    for (const auto& [name, value] : scenario.initial_joints) rest[robot.tree.find_joint(name)] = value;
    spec.left_foot = "L_ANKLE_R_LINK";
    spec.right_foot = "R_ANKLE_R_LINK";
  }
};

class OwnRobots : public ::testing::TestWithParam<const char*> {};

TEST_P(OwnRobots, CentreOfMassAndSolesAreWhereTheyWereAskedFor) {
  const Body b(GetParam());
  WholeBody body(b.robot, b.spec, b.rest);
  ASSERT_TRUE(body.has_closed_form());
  Transform soles[2] = {body.get_sole(kLeft), body.get_sole(kRight)};
  soles[kLeft].p += Vector3d(0.1, 0.01, 0.03);
  soles[kLeft].R = make_rotation_from_rpy({0.05, -0.1, 0.2}) * soles[kLeft].R;
  const Vector3d com = body.get_com() + Vector3d(0.02, 0.05, -0.03);
  const Matrix3d R_WB = make_rotation_from_rpy({0.02, 0.1, 0.05});
  Eigen::VectorXd q;
  ASSERT_TRUE(body.solve(com, R_WB, soles, &q));
  WholeBody check(b.robot, b.spec, q);
  const Transform X_WB{R_WB, com - R_WB * check.get_com()};
  for (Side side : {kLeft, kRight}) {
    const Transform sole = X_WB * check.get_sole(side);
    EXPECT_LT((sole.p - soles[side].p).norm(), 2e-6) << "as far as the centre of mass was iterated";
    EXPECT_LT((sole.R - soles[side].R).norm(), 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenarios, OwnRobots, ::testing::Values("hrp2p_stand.yaml", "hrp1s_stand.yaml"));

TEST(WholeBody, FeetOutOfReachAreSaid) {
  const Body b("hrp2p_stand.yaml");
  WholeBody body(b.robot, b.spec, b.rest);
  Transform soles[2] = {body.get_sole(kLeft), body.get_sole(kRight)};
  soles[kLeft].p.x() += 1.0;
  Eigen::VectorXd q;
  EXPECT_FALSE(body.solve(body.get_com(), Matrix3d::Identity(), soles, &q));
  EXPECT_TRUE(q.allFinite());
}

TEST(Estimate, ZmpOfAFootFromASensorThatIsTurnedAndHigher) {
  // 500 N at (0.03, -0.02) on the sole; the sensor sits 0.1 m above, turned by 90 degrees about z.
  const Transform X_SF{make_rotation_from_rpy({0, 0, M_PI / 2}), {0, 0, 0.1}};
  const Vector3d force_S(20, -10, 500), zmp_S(0.03, -0.02, 0);
  WrenchSample wrench;
  wrench.force = X_SF.R.transpose() * force_S;
  wrench.torque = X_SF.R.transpose() * (zmp_S - X_SF.p).cross(force_S);
  const FootLoad load = calc_foot_load(wrench, X_SF.inverse());
  EXPECT_LT((calc_foot_zmp(load, 1.0) - Vector2d(0.03, -0.02)).norm(), 1e-12);
}

TEST(Estimate, AttitudeFromGyroAndAccelerometerFollowsASwayAndForgetsAWrongStart) {
  AttitudeFilter filter(2.0);
  filter.reset(make_rotation_from_rpy({0.1, -0.05, 0.0}));  // wrong by 0.1 and 0.05 rad
  const double dt = 0.005;
  Matrix3d truth;
  for (int k = 0; k < 4000; ++k) {
    const double t = k * dt, pitch = 0.05 * std::sin(2.0 * t), rate = 0.1 * std::cos(2.0 * t);
    truth = make_rotation_from_rpy({0.0, pitch, 0.0});
    filter.update({0.0, rate, 0.0}, truth.transpose() * Vector3d(0, 0, 9.81), dt);
  }
  const Vector3d up = Vector3d::UnitZ();  // heading cannot be seen
  EXPECT_LT((filter.get().transpose() * up - truth.transpose() * up).norm(), 1e-3)
      << "a sample late at 0.1 rad/s is 5e-4";
}

TEST(Laws, EachPushesBack) {
  StabilizerSpec spec;
  Vector2d integral = Vector2d::Zero();
  EXPECT_LT(calc_inclination_turn(spec, {0.02, 0.0}, {0.0, 0.0}, 0.005, &integral).x(), 0.0) << "a lean is turned back";
  EXPECT_GT(update_zmp_damping(spec, {0.01, 0.0}, 0.005, Vector2d::Zero()).x(), 0.0) << "the body follows the ZMP";
  EXPECT_GT(update_foot_turn(spec, {5.0, 0.0}, 0.005, Vector2d::Zero()).x(), 0.0) << "the foot yields";
  EXPECT_GT(update_foot_lift(spec, 50.0, true, 0.005, 0.0), 0.0) << "the loaded left foot is raised";
}

TEST(Laws, StayWithinTheirLimitsWhateverTheyAreFed) {
  StabilizerSpec spec;
  Vector2d integral = Vector2d::Zero(), offset = Vector2d::Zero(), turn = Vector2d::Zero();
  double lift = 0.0;
  spec.inclination_integral = 1.0;
  for (int k = 0; k < 1000; ++k) {
    EXPECT_LE(calc_inclination_turn(spec, {1e3, -1e3}, {1e3, 1e3}, 0.005, &integral).cwiseAbs().maxCoeff(),
              spec.inclination_limit);
    offset = update_zmp_damping(spec, {1e3, -1e3}, 0.005, offset);
    turn = update_foot_turn(spec, {1e6, -1e6}, 0.005, turn);
    lift = update_foot_lift(spec, 1e6, true, 0.005, lift);
  }
  EXPECT_LE(offset.cwiseAbs().maxCoeff(), spec.zmp_limit);
  EXPECT_LE(turn.cwiseAbs().maxCoeff(), spec.foot_limit);
  EXPECT_LE(std::abs(lift), spec.height_limit);
}

TEST(Laws, AFootThatMeetsTheGroundEarlyStopsThereAndSettlesLater) {
  StabilizerSpec spec;
  double lift = 0.0, reference = 0.010;  // [m] when it touches
  for (; reference > 1e-9; reference -= 0.001) lift = update_landing(spec, true, 0.001, 0.005, lift);
  EXPECT_NEAR(lift, 0.010, 1e-12) << "as high as where it touched";
  for (int k = 0; k < 400; ++k) lift = update_landing(spec, false, 0.0, 0.005, lift);
  EXPECT_LT(lift, 1e-4) << "two seconds are more than six time constants";
  EXPECT_EQ(update_landing(spec, true, 1.0, 0.005, 0.0), spec.height_limit);
}

TEST(Laws, StepsFollowTheDivergentComponentBeyondTheDeadBand) {
  StepAdjustmentSpec spec;
  EXPECT_TRUE(calc_step_shift(spec, {0.9 * spec.dead_band, -spec.dead_band}).isZero(0.0));
  EXPECT_LT((calc_step_shift(spec, {0.05, -0.06}) - Vector2d(0.02, -0.03)).norm(), 1e-12)
      << "a step to the capture point";
  EXPECT_LE(calc_step_shift(spec, {1e6, -1e6}).cwiseAbs().maxCoeff(), spec.limit);
}

TEST(Laws, TheBodyFollowsItsFeetWithoutOvershootWhateverThePeriod) {
  Follower fine, coarse;
  const Vector2d goal(0.05, -0.02);
  for (int k = 0; k < 400; ++k) {
    fine = update_follower(fine, goal, 5.0, 0.005);
    EXPECT_LE(fine.x.x(), goal.x());
    if (k % 100 == 99) coarse = update_follower(coarse, goal, 5.0, 0.5);
  }
  EXPECT_LT((fine.x - coarse.x).norm(), 1e-12) << "exact solution";
  EXPECT_LT((fine.x - goal).norm(), 5e-5) << "(1 + w t) exp(-w t) = 5e-4 after 2 s";
}

TEST(Laws, LoadsOfBothFeetPutTheZmpWhereItWasAskedFor) {
  Transform soles[2];
  soles[kLeft].p = {0.1, 0.095, 0.0};
  soles[kRight].p = {0.0, -0.095, 0.0};
  const Vector3d zmp(0.06, 0.02, 0.0);
  const LoadReference load = distribute(zmp, soles, true, true, 569.0);
  EXPECT_NEAR(load.force[0] + load.force[1], 569.0, 1e-9);
  Vector2d sum = Vector2d::Zero();
  for (int side : {0, 1}) {
    sum += load.force[side] * soles[side].p.head<2>() + Vector2d(-load.torque[side].y(), load.torque[side].x());
  }
  EXPECT_LT((sum / 569.0 - zmp.head<2>()).norm(), 1e-12);
}

}  // namespace
}  // namespace hrp::walking
