// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "common/multibody/tree_mass.h"
#include "common/spatial/gravity.h"
#include "servers/dynamics/engine.h"
#include "servers/model_parser/robot_loader.h"
#include "servers/mujoco_dynamics/engine.h"
#include "servers/mujoco_dynamics/ground_law.h"
#include "tests/test_places.h"

namespace hrp {
namespace {

const std::string kStand = source_dir() + "/models/scenarios/hrp2p_stand.yaml";

double calc_weight(const TreeSpec& tree) { return calc_mass(tree) * kGravity; }

class MujocoDynamicsTest : public testing::Test {
 protected:
  MujocoDynamicsTest()
      : scenario_(load_scenario(kStand)),
        robot_(load_robot(scenario_)),
        engine_(make_mujoco_engine(robot_, scenario_)) {
    command_.q = engine_->state().q;
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) ASSERT_EQ(engine_->step({}, command_), "") << "step " << i;
  }
  Scenario scenario_;
  RobotDescription robot_;
  std::unique_ptr<DynamicsEngine> engine_;
  JointCommand command_;
};

TEST_F(MujocoDynamicsTest, TheRobotStandsAndItsFeetCarryTheWeight) {
  const double height = engine_->state().p_WB.z();
  run(3000);
  // It settles by millimetres: soft contact and a servo without integral action.
  EXPECT_NEAR(engine_->state().p_WB.z(), height, 0.02);
  const std::vector<double>& feet = engine_->foot_forces();
  const double sum = std::accumulate(feet.begin(), feet.end(), 0.0);
  // One per mille: what is left of the settling after three seconds.
  EXPECT_NEAR(sum, calc_weight(robot_.tree), 1e-3 * calc_weight(robot_.tree));
  ASSERT_EQ(feet.size(), 2u);
  EXPECT_GT(feet[0], 0.3 * sum);
  EXPECT_GT(feet[1], 0.3 * sum);
}

TEST_F(MujocoDynamicsTest, TotalsAreTheSumOfTheirParts) {
  run(500);
  ASSERT_FALSE(engine_->contact_forces().empty());
  for (const PairForce& pair : engine_->contact_forces()) {
    EXPECT_EQ(pair.total, Vector6d(pair.spring + pair.damper + pair.friction));
    Vector3d sum = Vector3d::Zero();
    for (const PointForce& point : pair.points) sum += point.total;
    // Rounding of a handful of sums of forces of some hundred newton.
    EXPECT_LT((sum - pair.total.tail<3>()).norm(), 1e-9);
  }
}

TEST_F(MujocoDynamicsTest, StandingGivesPositiveForceAndUprightGravity) {
  run(3000);
  const SensorSample& sensors = engine_->sensors();
  ASSERT_EQ(sensors.wrenches.size(), 2u);
  EXPECT_GT(sensors.wrenches[0].force.z(), 100.0);
  ASSERT_EQ(sensors.imus.size(), 1u);
  const Vector3d specific_force_W = sensors.imus[0].R_WS * sensors.imus[0].linear_acceleration;
  // The robot still sways a little.
  EXPECT_NEAR(specific_force_W.z(), 9.81, 0.05);
}

// A floor that is stiffer than the scenario's shakes with the stabilizer: 157 N rms in the default walk.
TEST_F(MujocoDynamicsTest, TheFloorGivesUnderTheFeetAsTheScenarioSays) {
  scenario_.contact.stiffness = 2e5;
  engine_ = make_mujoco_engine(robot_, scenario_);
  run(3000);
  for (const PairForce& pair : engine_->contact_forces()) {
    double depth = 0;
    for (const PointForce& point : pair.points) depth += point.depth / static_cast<double>(pair.points.size());
    // Two per cent: the robot still sways a little, and MuJoCo's solver stops at 1e-8.
    EXPECT_NEAR(depth, pair.total[5] / scenario_.contact.stiffness, 0.02 * depth);
  }
}

TEST(GroundLawTest, IsTheTangentOfEquation3WhereThePointCarriesItsLoad) {
  ContactSpec contact;
  contact.stiffness = 4e5;
  contact.shared_points = 4;
  contact.exponent = 1.5;
  contact.alpha = 2.4;
  const double load = 100.0, mass = 4.0, K = 1e5, h = 1e-7;
  const auto force = [&](double depth, double rate) {
    return K * std::pow(depth, 1.5) * (1.0 + 1.5 * contact.alpha * rate);
  };
  const double depth = std::pow(load / K, 1.0 / 1.5);
  const GroundLaw law = calc_ground_law(contact, load, mass, 1e-3);
  const double R = (1.0 - law.impedance) / law.impedance / mass;
  // 1e-6: what central differences leave of a power law.
  EXPECT_NEAR(law.k / R, (force(depth + h, 0) - force(depth - h, 0)) / (2 * h), 1e-6 * law.k / R);
  EXPECT_NEAR(law.b / R, (force(depth, h) - force(depth, -h)) / (2 * h), 1e-6 * law.b / R);
}

TEST(GroundLawTest, AStiffFloorTurnsAPointByLessThanAThirdOfARadianInAStep) {
  ContactSpec contact;  // 1e7 N/m
  const GroundLaw law = calc_ground_law(contact, 100.0, 4.0, 1e-3);
  EXPECT_GT(law.impedance, 0.5);
  EXPECT_LT(std::sqrt(law.k) * 1e-3, 0.33);
}

TEST_F(MujocoDynamicsTest, ResetRepeatsTheRunToTheBit) {
  run(300);
  const unsigned long long hash = engine_->state_hash();
  engine_->reset();
  run(300);
  EXPECT_EQ(engine_->state_hash(), hash);
}

// A slow squat from references every 5 ms. Held through the period, each of them kicks the feet: 38 N rms.
TEST_F(MujocoDynamicsTest, ReferencesAreInterpolatedSoThatASquatDoesNotRippleTheFootForce) {
  std::vector<double> sums;
  const Eigen::VectorXd start = command_.q;
  for (int step = 0; step < 1500; ++step) {
    const double bend =
        0.15 * (1.0 - std::cos(1e-3 * (step - step % 5 + 5)));  // [rad] of ankle and hip, twice of the knee
    for (const char* side : {"R_", "L_"}) {
      const auto joint = [&](const char* name) { return robot_.tree.find_joint(std::string(side) + name); };
      command_.q[joint("HIP_P")] = start[joint("HIP_P")] - bend;
      command_.q[joint("KNEE")] = start[joint("KNEE")] + 2 * bend;
      command_.q[joint("ANKLE_P")] = start[joint("ANKLE_P")] - bend;
    }
    ASSERT_EQ(engine_->step({}, command_), "");
    const std::vector<double>& feet = engine_->foot_forces();
    sums.push_back(std::accumulate(feet.begin(), feet.end(), 0.0));
  }
  double square = 0;
  for (size_t k = 1000; k < 1490; ++k) {
    const double mean =
        std::accumulate(sums.begin() + static_cast<long>(k) - 5, sums.begin() + static_cast<long>(k) + 5, 0.0) / 10.0;
    square += (sums[k] - mean) * (sums[k] - mean) / 490.0;
  }
  // A straight line between references still turns by a small angle at each of them.
  EXPECT_LT(std::sqrt(square), 2.0) << "[N] rms about the mean over two control periods";
}

// The robot floats without weight: a push and a hand at the ends of two limbs move and turn all of it.
TEST_F(MujocoDynamicsTest, PushesAndHandsMoveTheRobotAsInOurDynamics) {
  scenario_.gravity_W.setZero();
  scenario_.initial_position.z() = 3.0;
  scenario_.initial_height_given = true;
  scenario_.pushes.push_back({"shove", "L_ANKLE_R_LINK", {0.05, 0.02, -0.01}, {10.0, -20.0, 5.0}, 0.1, 0.2});
  HandSpec hand;
  hand.name = "grip";
  hand.link = "R_ANKLE_R_LINK";
  hand.p_LQ = {0.1, 0.0, 0.0};
  hand.stiffness_W.setConstant(100.0);
  hand.damping_W.setConstant(10.0);
  hand.path = {{0.4, {0.1, 0.0, 0.05}}};
  scenario_.hands.push_back(hand);
  engine_ = make_mujoco_engine(robot_, scenario_);
  const std::unique_ptr<DynamicsEngine> ours = make_simulator_engine(robot_, scenario_);
  const State start = ours->state();
  double largest = 0.0;
  for (int i = 0; i < 500; ++i) {
    ASSERT_EQ(engine_->step({}, command_) + ours->step({}, command_), "") << "step " << i;
    ASSERT_EQ(engine_->pushes().size(), ours->pushes().size()) << "step " << i;
    for (size_t k = 0; k < ours->pushes().size(); ++k) {
      EXPECT_EQ(engine_->pushes()[k].name, ours->pushes()[k].name);
      largest = std::max(largest, (engine_->pushes()[k].force_W - ours->pushes()[k].force_W).norm());
    }
  }
  const State& mujoco = engine_->state();
  const State& our = ours->state();
  const double way = (our.p_WB - start.p_WB).norm(), turn = our.R_WB.angularDistance(start.R_WB);
  EXPECT_GT(way, 0.03);
  EXPECT_GT(turn, 0.1);
  // Two integrators of first order at 1 ms: over 0.5 s they may differ by some thousandths of the motion.
  EXPECT_LT((mujoco.p_WB - our.p_WB).norm(), 2e-3 * way);
  EXPECT_LT(mujoco.R_WB.angularDistance(our.R_WB), 2e-3 * turn);
  EXPECT_LT(largest, 0.1) << "[N] the hand pulls with about 10 N, and its damper feels the servos shake";
}

TEST_F(MujocoDynamicsTest, ALivePushLastsUntilTheNext) {
  ASSERT_TRUE(engine_->push({{"", "base_link", {0, 0, 0}, {20.0, 0, 0}}}));
  run(2000);
  Vector3d sum = Vector3d::Zero();
  for (const PairForce& pair : engine_->contact_forces()) sum += pair.total.tail<3>();
  EXPECT_NEAR(sum.x(), -20.0, 2.0) << "[N] the feet hold against it; the robot still sways";
  ASSERT_TRUE(engine_->push({}));
  run(1);
  EXPECT_TRUE(engine_->pushes().empty());
}

// A robot on a ceiling hangs from it: gravity pulls its arms the other way.
TEST_F(MujocoDynamicsTest, AFixedBaseIsWhereTheScenarioPutsIt) {
  scenario_.floating_base = false;
  scenario_.initial_position = {0.3, -0.2, 3.0};
  scenario_.initial_height_given = true;
  scenario_.initial_rpy = {M_PI - 0.1, 0.3, -0.5};
  robot_ = load_robot(scenario_);
  engine_ = make_mujoco_engine(robot_, scenario_);
  const std::unique_ptr<DynamicsEngine> ours = make_simulator_engine(robot_, scenario_);
  command_.q = engine_->state().q;
  for (int i = 0; i < 500; ++i) ASSERT_EQ(engine_->step({}, command_) + ours->step({}, command_), "") << "step " << i;
  EXPECT_EQ(engine_->state().p_WB, ours->state().p_WB);
  EXPECT_LT(engine_->state().R_WB.angularDistance(ours->state().R_WB), 1e-12) << "rounding";
  // [m/s^2] Gravity about the chest's axes: it gives by less than a mrad, alike to a tenth of that.
  EXPECT_LT((engine_->sensors().imus[0].linear_acceleration - ours->sensors().imus[0].linear_acceleration).norm(),
            1e-3);
  // Servos without integral action give by some mrad under the limbs' weight; two integrators agree to a hundredth.
  const Eigen::VectorXd our_sag = ours->state().q - command_.q;
  EXPECT_GT(our_sag.cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_LT((engine_->state().q - ours->state().q).cwiseAbs().maxCoeff(), 0.01 * our_sag.cwiseAbs().maxCoeff());
}

TEST_F(MujocoDynamicsTest, TheScenariosEffortLimitReplacesThatOfTheModel) {
  const int knee = robot_.tree.find_joint("R_KNEE");
  robot_.tree.links[static_cast<size_t>(knee) + 1].joint.effort_limit = 1.0;
  engine_ = make_mujoco_engine(robot_, scenario_);
  run(300);
  EXPECT_LE(std::abs(engine_->joint_efforts()[knee]), 1.5) << "[N m] the limit and what the joint itself takes";
  scenario_.servo_joints["R_KNEE"] = scenario_.servo_default;
  scenario_.servo_joints["R_KNEE"].effort_limit = 300.0;
  engine_ = make_mujoco_engine(robot_, scenario_);
  run(300);
  EXPECT_GT(std::abs(engine_->joint_efforts()[knee]), 5.0) << "[N m] bent knees bear the body";
}

TEST_F(MujocoDynamicsTest, WhatItCannotDoIsRefusedByName) {
  const auto find_refusal = [&](const std::function<void(Scenario*)>& change) -> std::string {
    Scenario scenario = scenario_;
    change(&scenario);
    try {
      make_mujoco_engine(robot_, scenario);
    } catch (const InputError& error) {
      return error.what();
    }
    return "it was accepted";
  };
  EXPECT_THAT(find_refusal([](Scenario* s) { s->foot_bush["L_ANKLE_R_LINK"] = FootBushSpec(); }),
              testing::HasSubstr("foot bush"));
  EXPECT_THAT(find_refusal([](Scenario* s) { s->joint_stops = true; }), testing::HasSubstr("joint_stops"));
  EXPECT_THAT(find_refusal([](Scenario* s) { s->self_collision = true; }), testing::HasSubstr("self_collision"));
  EXPECT_THAT(find_refusal([](Scenario* s) { s->variation.mass = 0.1; }), testing::HasSubstr("variation"));
  EXPECT_THAT(find_refusal([](Scenario* s) { s->variation.pose = 0.1; }), testing::HasSubstr("variation"));
}

}  // namespace
}  // namespace hrp
