// SPDX-License-Identifier: BSD-3-Clause
// What a single body does on the ground: weight, slopes, bounces.
#include <gtest/gtest.h>

#include "common/multibody/kinematics.h"
#include "tests/physics/rigs.h"
#include "tests/physics/solutions/contact_solutions.h"

namespace hrp {
namespace {

using rigs::CornerFinder;

constexpr double kMass = 12.0;
const Vector3d kHalf(0.10, 0.06, 0.05);

struct BlockRun {
  RobotDescription robot = rigs::make_body(rigs::make_box_inertia(kMass, 2.0 * kHalf));
  Scenario scenario = rigs::make_scenario();
  CornerFinder finder;
  double slope = 0.0;  // [rad] about y

  BlockRun() { finder.add_box(0, kHalf); }

  // A simulator with the block laid on the slope.
  Simulator make() {
    finder.n = Eigen::AngleAxisd(slope, Vector3d::UnitY()) * Vector3d::UnitZ();
    scenario.initial_rpy = Vector3d(0, slope, 0);
    scenario.initial_position = (kHalf.z() - 1e-4) * finder.n;
    return Simulator(robot, scenario);
  }
  void run(Simulator* simulator, int steps) {
    const Model model(simulator->tree());
    for (int i = 0; i < steps; ++i) {
      const JointCommand none;
      ASSERT_EQ(simulator->step(finder.find(model, simulator->state()), none), StepStatus::kOk)
          << simulator->fault_text();
    }
  }
};

double calc_vertical_force(const Simulator& simulator) {
  double force = 0.0;
  for (const PairForce& pair : simulator.contact_forces()) force += pair.total[5];
  return force;
}

TEST(ContactAtRest, CarriesTheWeight) {
  for (const char* model : {"spring_damper", "impulse"}) {
    BlockRun block;
    block.scenario.contact.model = model;
    Simulator simulator = block.make();
    block.run(&simulator, 4000);
    // 4 s is many decay times; what is left is rounding.
    EXPECT_NEAR(calc_vertical_force(simulator) / (kMass * 9.81), 1.0, 1e-6) << model;
    EXPECT_LT(simulator.state().V_WB.norm(), 1e-7) << model;
  }
}

TEST(ContactAtRest, SinksInByWeightOverStiffness) {
  BlockRun block;
  Simulator simulator = block.make();
  block.run(&simulator, 4000);
  EXPECT_NEAR(kHalf.z() - simulator.state().p_WB.z(), kMass * 9.81 / block.scenario.contact.stiffness, 1e-9);
}

TEST(BlockOnSlope, SticksBelowTheFrictionAngle) {
  for (const char* model : {"spring_damper", "impulse"}) {
    BlockRun block;
    block.scenario.contact.model = model;
    block.slope = std::atan(block.finder.friction) - 0.01;
    Simulator simulator = block.make();
    block.run(&simulator, 1000);
    const Vector3d settled = simulator.state().p_WB;
    block.run(&simulator, 4000);
    // No creep: less than a nanometre in four seconds.
    EXPECT_LT((simulator.state().p_WB - settled).norm(), 1e-9) << model;
  }
}

TEST(BlockOnSlope, SlidesAboveTheFrictionAngleAtTheClosedFormRate) {
  for (const char* model : {"spring_damper", "impulse"}) {
    BlockRun block;
    block.scenario.contact.model = model;
    block.finder.friction = 0.4;
    block.slope = std::atan(0.4) + 0.05;
    Simulator simulator = block.make();
    block.run(&simulator, 500);
    const double v0 = simulator.state().V_WB.tail<3>().norm();
    block.run(&simulator, 1000);
    const double gained = simulator.state().V_WB.tail<3>().norm() - v0;
    // The contact has settled after 0.5 s; from there on the acceleration is constant.
    EXPECT_NEAR(gained / solutions::calc_slide_acceleration(9.81, block.slope, 0.4), 1.0, 1e-4) << model;
  }
}

TEST(BlockOnFloor, SlidesToAStopWithinTheClosedFormDistance) {
  BlockRun block;
  Simulator simulator = block.make();
  block.run(&simulator, 500);
  State state = simulator.state();
  state.V_WB[3] = 1.0;
  ASSERT_TRUE(simulator.reset(state));
  block.run(&simulator, 1000);
  // First-order step: the distance is right to a few steps' worth of travel.
  EXPECT_NEAR(simulator.state().p_WB.x() - state.p_WB.x(), 1.0 / (2 * 9.81 * 0.8), 2e-3);
  EXPECT_LT(simulator.state().V_WB.norm(), 1e-4);
}

// [H03 eq. 2] of a sole that rolls: one edge presses, the other leaves. Forces now, so that they can be told by hand.
TEST(TiltingBlock, IsDampedByItsProjectedTwistAndAlongTheFloor) {
  BlockRun block;
  block.scenario.integrator = "semi_implicit_euler";
  Simulator simulator = block.make();
  State state = simulator.state();
  state.p_WB.z() = kHalf.z() - 1e-3;
  state.V_WB << 0, 1.0, 0, 0, 0, -0.02;
  ASSERT_TRUE(simulator.reset(state));
  block.run(&simulator, 1);
  // By hand: x = (w l, vz) with l = 0.1 m, cone -vz >= 0.1 m abs(w). (1, -0.2) / 10 goes to its edge: w = 0.6, vz =
  // -0.06.
  const double w = 0.6, vz = -0.06, lambda = 1.5 * block.scenario.contact.alpha * block.scenario.contact.stiffness / 4;
  for (const PointForce& point : simulator.contact_forces().at(0).points) {
    const double pressing = -(vz - w * point.p_WC.x());
    EXPECT_NEAR(point.damper.z(), lambda * 1e-3 * pressing, 1e-6 * lambda * 1e-3) << point.p_WC.transpose();
    // [H03 eq. 5]: the soles' speed is w times the height, along the floor; nothing sticks yet.
    const double speed = 1.0 * (point.p_WC.z() - state.p_WB.z());
    EXPECT_LT((point.friction - Vector3d(-block.scenario.contact.tangential_damping / 4 * speed, 0, 0)).norm(), 1e-6);
  }
}

TEST(LeavingBlock, IsNotHeldByImpulses) {
  BlockRun block;
  block.scenario.contact.model = "impulse";
  Simulator simulator = block.make();
  State state = simulator.state();
  state.p_WB.z() = kHalf.z() - 5e-5;  // less than what is taken out
  state.V_WB[5] = 0.5;
  ASSERT_TRUE(simulator.reset(state));
  block.run(&simulator, 1);
  EXPECT_NEAR(simulator.state().V_WB[5], 0.5 - 9.81e-3, 1e-9);
}

// A ball (one point) dropped so that it lands at `speed`; returns rebound speed over landing speed.
double calc_measured_restitution(double speed, double alpha, const std::string& damping, double dt) {
  Scenario scenario = rigs::make_scenario();
  scenario.contact.shared_points = 1;
  scenario.contact.alpha = alpha;
  scenario.contact.damping = damping;
  scenario.contact.stiffness = 1e5;
  scenario.time_step = dt;
  scenario.gravity_W.setZero();  // the closed form leaves weight out
  CornerFinder finder;
  finder.corners.push_back({0, Vector3d::Zero()});
  Simulator simulator(rigs::make_body(rigs::make_box_inertia(1.0, {0.1, 0.1, 0.1})), scenario);
  State state = simulator.state();
  state.V_WB[5] = -speed;
  if (!simulator.reset(state)) return -1.0;
  const Model model(simulator.tree());
  for (int i = 0; i < 200000 && (simulator.state().p_WB.z() <= 0.0 || simulator.state().V_WB[5] <= 0.0); ++i) {
    if (simulator.step(finder.find(model, simulator.state()), JointCommand{}) != StepStatus::kOk) return -1.0;
  }
  return simulator.state().V_WB[5] / speed;
}

TEST(BouncingBall, ReboundsAsHuntAndCrossleyPredict) {
  for (double speed : {0.05, 0.25, 0.5}) {
    const double e = calc_measured_restitution(speed, 0.8, "two_sided", 1e-6);
    // 1 us steps: the first-order step takes about 1e-4 of the energy.
    EXPECT_NEAR(e, solutions::calc_hunt_crossley_restitution(speed, 0.8), 5e-4) << speed;
    // The rule of thumb e = 1 - alpha v.
    EXPECT_NEAR(e, 1.0 - 0.8 * speed, 0.8 * speed * speed) << speed;
  }
}

TEST(BouncingBall, LosesOnlyOnTheWayInWithProjectedVelocity) {
  for (double speed : {0.05, 0.25, 0.5}) {
    const double e = calc_measured_restitution(speed, 0.8, "projected", 1e-6);
    EXPECT_NEAR(e, solutions::calc_one_sided_restitution(speed, 0.8), 5e-4) << speed;
  }
}

TEST(BouncingBall, ReboundsWithTheImpulseModelsRestitution) {
  Scenario scenario = rigs::make_scenario();
  scenario.contact.model = "impulse";
  scenario.contact.restitution = 0.6;
  scenario.gravity_W.setZero();
  CornerFinder finder;
  finder.corners.push_back({0, Vector3d::Zero()});
  Simulator simulator(rigs::make_body(rigs::make_box_inertia(1.0, {0.1, 0.1, 0.1})), scenario);
  State state = simulator.state();
  state.V_WB[5] = -1.0;
  ASSERT_TRUE(simulator.reset(state));
  const Model model(simulator.tree());
  ASSERT_EQ(simulator.step(finder.find(model, state), JointCommand{}), StepStatus::kOk);
  EXPECT_NEAR(simulator.state().V_WB[5], 0.6, 1e-9);
}

}  // namespace
}  // namespace hrp
