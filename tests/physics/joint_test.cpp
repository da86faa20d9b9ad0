// SPDX-License-Identifier: BSD-3-Clause
// What the joint laws do to a single joint: a bar on a fixed base, turning about a vertical axis (no weight).
#include <gtest/gtest.h>

#include <cmath>

#include "servers/dynamics/joint_effects.h"
#include "tests/physics/rigs.h"
#include "tests/physics/solutions/dynamics_solutions.h"

namespace hrp {
namespace {

constexpr double kInertia = 0.5;  // [kg m^2] about the axis

struct Bar {
  RobotDescription robot = rigs::make_body(rigs::make_box_inertia(1.0, {0.1, 0.1, 0.1}));
  Scenario scenario = rigs::make_scenario();
  JointCommand command;

  Bar() {
    LinkInertia inertia;
    inertia.mass = 1.0;
    inertia.I_LLcm_L = Vector3d::Constant(kInertia).asDiagonal();
    rigs::add_link(&robot, "bar", 0, Vector3d::Zero(), Vector3d::UnitZ(), inertia);
    scenario.floating_base = false;
    command.q = command.qd = command.effort = Eigen::VectorXd::Zero(1);
  }
  void add(const std::string& effect, const std::map<std::string, double>& parameters) {
    scenario.joint_laws["bar_joint"].push_back({effect, parameters});
  }
  void set_servo(double kp, double kd) {
    scenario.servo_default.kp = kp;
    scenario.servo_default.kd = kd;
  }
  Simulator start(double q, double qd) const {
    Simulator simulator(robot, scenario);
    State state = simulator.state();
    state.q[0] = q;
    state.qd[0] = qd;
    EXPECT_TRUE(simulator.reset(state));
    return simulator;
  }
  void run(Simulator* simulator, int steps) const {
    for (int i = 0; i < steps; ++i) {
      ASSERT_EQ(simulator->step({}, command), StepStatus::kOk) << simulator->fault_text();
    }
  }
};

TEST(CoulombFriction, HoldsExactlyBelowItsLevel) {
  Bar bar;
  bar.add("coulomb_friction", {{"level", 3.0}});
  bar.command.effort[0] = 2.999;
  Simulator simulator = bar.start(0.2, 0.0);
  bar.run(&simulator, 10000);
  EXPECT_EQ(simulator.state().q[0], 0.2);  // no creep: not one bit
  EXPECT_NEAR(simulator.joint_efforts()[0], 0.0, 1e-6);
}

TEST(CoulombFriction, LetsGoAboveItsLevelWithWhatIsLeft) {
  Bar bar;
  bar.add("coulomb_friction", {{"level", 3.0}});
  bar.command.effort[0] = 4.0;
  Simulator simulator = bar.start(0.0, 0.0);
  bar.run(&simulator, 1000);
  EXPECT_NEAR(simulator.state().qd[0], (4.0 - 3.0) / kInertia * 1.0, 1e-9);
}

TEST(CoulombFriction, StopsAMovingJointForGood) {
  Bar bar;
  bar.add("coulomb_friction", {{"level", 3.0}});
  Simulator simulator = bar.start(0.0, 1.2);
  bar.run(&simulator, 1000);
  EXPECT_EQ(simulator.state().qd[0], 0.0);
  // v^2 I / (2 level), known to one step's travel.
  EXPECT_NEAR(simulator.state().q[0], 1.2 * 1.2 * kInertia / 6.0, 1.2e-3);
}

// Dahl's law: friction is level (1 - exp(-x / d)) behind a displacement x from rest.
TEST(BendingFriction, GivesAtHalfItsLevelByTheLogarithmOfTwoTimesItsDisplacement) {
  Bar bar;
  bar.add("coulomb_friction", {{"level", 3.0}, {"presliding", 2e-3}});
  bar.add("viscous_friction", {{"coefficient", 60.0}});  // it gets there without swinging over
  bar.command.effort[0] = 1.5;
  Simulator simulator = bar.start(0.0, 0.0);
  bar.run(&simulator, 2000);
  EXPECT_NEAR(simulator.state().q[0], 2e-3 * std::log(2.0), 2e-5);  // a hundredth: steps of 1 ms on the way
}

TEST(BendingFriction, InMotionAndWhereItSlipsAtOnceIsThatOfConstantLevel) {
  for (double displacement : {2e-3, 1e-6}) {
    Bar bar;
    bar.add("coulomb_friction", {{"level", 3.0}, {"presliding", displacement}});
    bar.command.effort[0] = 4.0;
    Simulator simulator = bar.start(0.0, 0.0);
    bar.run(&simulator, 1000);
    // Before it slips it takes less than 3 N m; the energy that it leaves to the bar is 3 N m times the displacement.
    EXPECT_NEAR(simulator.state().qd[0], 2.0, std::sqrt(2.0 * 3.0 * displacement / kInertia)) << displacement;
  }
}

TEST(BendingFriction, BrakesASlidingJointToRestWhateverItsDisplacement) {
  for (double displacement : {2e-3, 1e-6}) {
    Bar bar;
    bar.add("coulomb_friction", {{"level", 3.0}, {"presliding", displacement}});
    bar.add("viscous_friction", {{"coefficient", 20.0}});
    Simulator simulator = bar.start(0.0, 1.2);
    bar.run(&simulator, 2000);
    EXPECT_NEAR(simulator.state().qd[0], 0.0, 1e-6) << displacement;
  }
}

TEST(StribeckFriction, TakesMoreToStartThanToKeepMoving) {
  Bar bar;
  bar.add("stribeck_friction", {{"coulomb", 1.0}, {"static", 2.0}, {"stribeck_velocity", 0.05}});
  bar.command.effort[0] = 1.5;
  Simulator resting = bar.start(0.0, 0.0), moving = bar.start(0.0, 1.0);
  bar.run(&resting, 500);
  bar.run(&moving, 500);
  EXPECT_EQ(resting.state().qd[0], 0.0);
  EXPECT_NEAR(moving.state().qd[0], 1.0 + 0.5 * 0.5 / kInertia, 1e-6);
}

TEST(LoadDependentFriction, GrowsWithTheDrivesEffort) {
  Bar bar;
  bar.add("load_dependent_friction", {{"ratio", 0.25}});
  bar.command.effort[0] = 4.0;
  Simulator simulator = bar.start(0.0, 0.1);
  bar.run(&simulator, 100);
  EXPECT_NEAR(simulator.state().qd[0], 0.1 + 0.1 * (4.0 - 1.0) / kInertia, 1e-9);
}

// A gear of which the load gets only 1 - ratio backwards.
TEST(BackdrivingFriction, ADriveThatLeadsLosesNothingAndOneThatBrakesFeelsHalfTheLoad) {
  Bar bar;
  bar.add("backdriving_friction", {{"ratio", 0.5}});
  bar.command.effort[0] = 4.0;
  Simulator leads = bar.start(0.0, 0.1), brakes = bar.start(0.0, -1.0);
  bar.run(&leads, 50);
  bar.run(&brakes, 50);
  EXPECT_NEAR(leads.state().qd[0], 0.1 + 0.05 * 4.0 / kInertia, 1e-9);
  EXPECT_NEAR(brakes.state().qd[0], -1.0 + 0.05 * (4.0 / 0.5) / kInertia, 1e-9);
}

TEST(BackdrivingFriction, RotorAndViscousLossActThroughTheGear) {
  Bar bar;
  bar.add("backdriving_friction", {{"ratio", 0.75}});
  bar.add("viscous_friction", {{"coefficient", 0.5}});
  bar.add("rotor_inertia", {{"inertia", 0.1}});
  bar.scenario.time_step = 1e-4;
  Simulator simulator = bar.start(0.0, 1.0);
  bar.run(&simulator, 1000);
  // (1 - ratio) L v' = -b v - J v' while the load leads: rate b / ((1 - ratio) L + J) = 0.5 / 0.225. 1e-4 of steps.
  EXPECT_NEAR(simulator.state().qd[0], std::exp(-0.5 / (0.25 * kInertia + 0.1) * 0.1), 3e-4);
}

TEST(BackdrivingFriction, ALoadIsHeldByMoreThanHalfOfItsTorque) {
  Bar bar;
  bar.robot = rigs::make_body(rigs::make_box_inertia(1.0, {0.1, 0.1, 0.1}));
  LinkInertia inertia;
  inertia.mass = 1.0;
  inertia.p_LLcm_L = {0.1, 0.0, 0.0};
  inertia.I_LLcm_L = Vector3d::Constant(0.49).asDiagonal();
  rigs::add_link(&bar.robot, "bar", 0, Vector3d::Zero(), Vector3d::UnitY(), inertia);
  bar.add("backdriving_friction", {{"ratio", 0.5}});
  const double weight = 0.1 * 9.81;  // [N m], along +q
  bar.command.effort[0] = -0.51 * weight;
  Simulator held = bar.start(0.0, 0.0);
  bar.run(&held, 1000);
  EXPECT_NEAR(held.state().q[0], 0.0, 1e-12);
  bar.command.effort[0] = -0.4 * weight;
  Simulator falls = bar.start(0.0, 0.0);
  bar.run(&falls, 100);
  // 0.8 of the weight is carried; 1e-3 of the speed is the first step's.
  EXPECT_NEAR(falls.state().qd[0], 0.1 * 0.2 * weight / 0.5, 1e-3 * 0.05);
}

TEST(ViscousFriction, DecaysExponentially) {
  Bar bar;
  bar.add("viscous_friction", {{"coefficient", 2.0}});
  bar.scenario.time_step = 1e-4;
  Simulator simulator = bar.start(0.0, 1.0);
  bar.run(&simulator, 5000);
  EXPECT_NEAR(simulator.state().qd[0], std::exp(-2.0 / kInertia * 0.5), 1e-3);
}

TEST(JointElasticity, OscillatesBetweenRotorAndLink) {
  Bar bar;
  bar.add("joint_elasticity", {{"stiffness", 500.0}, {"damping", 0.0}, {"rotor_inertia", 0.2}});
  bar.scenario.time_step = 1e-5;
  Simulator simulator = bar.start(0.0, 0.1);  // the rotor is at rest, the link moves
  bar.run(&simulator, 5000);
  // Reduced inertia J L / (J + L): the twist is a free oscillation, the momentum stays.
  const double reduced = 0.2 * kInertia / (0.2 + kInertia), w = std::sqrt(500.0 / reduced), t = 0.05;
  const double mean = 0.1 * kInertia / (0.2 + kInertia);
  const double qd = mean + 0.1 * 0.2 / (0.2 + kInertia) * std::cos(w * t);
  // Implicit Euler takes w^2 dt t / 2 of the amplitude = 1e-3 relative.
  EXPECT_NEAR(simulator.state().qd[0], qd, 2e-4);
}

TEST(Backlash, LetsTheLinkRunFreeWithinTheGap) {
  Bar bar;
  bar.set_servo(5000.0, 100.0);
  bar.add("backlash", {{"gap", 0.02}, {"rotor_inertia", 0.1}});
  Simulator simulator = bar.start(0.0, 0.05);
  bar.run(&simulator, 190);  // 9.5 mrad: the link has not met the teeth
  EXPECT_NEAR(simulator.state().qd[0], 0.05, 1e-12);
  bar.run(&simulator, 40);
  EXPECT_LT(simulator.state().qd[0], 0.045);
}

TEST(Hysteresis, YieldsAtStiffnessTimesYieldAngle) {
  Bar bar;
  bar.add("hysteresis", {{"stiffness", 100.0}, {"yield_angle", 0.01}});
  bar.command.effort[0] = 0.9;
  Simulator held = bar.start(0.0, 0.0);
  bar.run(&held, 3000);
  EXPECT_LT(std::abs(held.state().qd[0]), 1.0);
  bar.command.effort[0] = 2.0;
  Simulator yielding = bar.start(0.0, 0.0);
  bar.run(&yielding, 1000);
  const double before = yielding.state().qd[0];
  bar.run(&yielding, 100);
  EXPECT_NEAR((yielding.state().qd[0] - before) / 0.1, (2.0 - 1.0) / kInertia, 1e-3);
}

TEST(ParallelSpring, HasTheFrequencyOfItsStiffness) {
  Bar bar;
  bar.add("parallel_spring", {{"stiffness", 50.0}, {"rest", 0.1}});
  bar.scenario.time_step = 1e-4;
  Simulator simulator = bar.start(0.2, 0.0);
  bar.run(&simulator, 3000);
  EXPECT_NEAR(simulator.state().q[0] - 0.1, solutions::calc_damped_oscillation(kInertia, 0.0, 50.0, 0.1, 0.3), 3e-4);
}

TEST(Cogging, AddsItsSineOfPosition) {
  Bar bar;
  bar.add("cogging", {{"amplitude", 1.5}, {"periods", 12.0}, {"phase", 0.4}});
  Simulator simulator = bar.start(0.3, 0.0);
  bar.run(&simulator, 1);
  EXPECT_NEAR(simulator.state().qd[0] * 1000.0, 1.5 * std::sin(12.0 * 0.3 + 0.4) / kInertia, 1e-4);
}

TEST(TorqueConstantError, ScalesTheTrueTorqueButNotTheLog) {
  Bar bar;
  bar.add("torque_constant_error", {{"scale", 0.7}});
  bar.command.effort[0] = 2.0;
  Simulator simulator = bar.start(0.0, 0.0);
  bar.run(&simulator, 1000);
  EXPECT_NEAR(simulator.state().qd[0], 0.7 * 2.0 / kInertia, 1e-9);
  EXPECT_NEAR(simulator.sensors().effort[0], 2.0, 1e-12);
}

TEST(TorqueSaturation, LimitsTheTrueTorqueButNotTheLog) {
  Bar bar;
  bar.add("torque_saturation", {{"limit", 1.0}});
  bar.command.effort[0] = 5.0;
  Simulator simulator = bar.start(0.0, 0.0);
  bar.run(&simulator, 1000);
  EXPECT_NEAR(simulator.state().qd[0], 1.0 / kInertia, 1e-9);
  EXPECT_NEAR(simulator.sensors().effort[0], 5.0, 1e-12);
}

TEST(EffortLimit, ClipsTheServo) {
  Bar bar;
  bar.set_servo(1e4, 10.0);
  bar.scenario.servo_default.effort_limit = 2.0;
  bar.command.q[0] = 10.0;
  Simulator simulator = bar.start(0.0, 0.0);
  bar.run(&simulator, 100);
  EXPECT_NEAR(simulator.sensors().effort[0], 2.0, 1e-12);
  EXPECT_NEAR(simulator.state().qd[0], 0.1 * 2.0 / kInertia, 1e-9);
}

TEST(ActuatorLag, ReachesTheEffortWithItsTimeConstant) {
  Bar bar;
  bar.add("actuator_lag", {{"time_constant", 0.05}});
  bar.command.effort[0] = 1.0;
  bar.scenario.interpolation = "hold";
  bar.scenario.time_step = 1e-4;
  Simulator simulator = bar.start(0.0, 0.0);
  bar.run(&simulator, 1000);
  const double t = 0.1, T = 0.05;
  EXPECT_NEAR(simulator.state().qd[0], (t - T * (1.0 - std::exp(-t / T))) / kInertia, 2e-4);
}

TEST(CommandDelay, ActsThatMuchLater) {
  Bar bar;
  bar.add("command_delay", {{"delay", 0.023}});
  bar.command.effort[0] = 1.0;
  bar.scenario.interpolation = "hold";
  Simulator simulator = bar.start(0.0, 0.0);
  bar.run(&simulator, 22);
  EXPECT_EQ(simulator.state().qd[0], 0.0);
  bar.run(&simulator, 100 - 22);
  EXPECT_NEAR(simulator.state().qd[0], (0.100 - 0.023) / kInertia, 0.0011 / kInertia);  // to one step
}

TEST(JointOffset, DeceivesServoAndLog) {
  Bar bar;
  bar.set_servo(400.0, 40.0);
  bar.add("joint_offset", {{"offset", 0.02}});
  bar.command.q[0] = 0.3;
  Simulator simulator = bar.start(0.0, 0.0);
  bar.run(&simulator, 5000);
  EXPECT_NEAR(simulator.state().q[0], 0.28, 1e-9);
  EXPECT_NEAR(simulator.sensors().q[0], 0.30, 1e-9);
}

TEST(PerfectJoints, AreExactlyAtTheirReferences) {
  Bar bar;
  bar.scenario.perfect_joints = true;
  Simulator simulator = bar.start(0.0, 0.0);
  for (int i = 0; i < 100; ++i) {
    bar.command.q[0] = 0.1 * std::sin(0.05 * i);
    bar.run(&simulator, 1);
    ASSERT_EQ(simulator.state().q[0], bar.command.q[0]);
  }
}

TEST(JointStop, KeepsTheJointWithinItsLimits) {
  Bar bar;
  bar.robot.tree.joint(0).lower = -0.1;
  bar.robot.tree.joint(0).upper = 0.1;
  bar.scenario.joint_stops = true;
  Simulator simulator = bar.start(0.0, 1.0);
  double largest = 0.0;
  for (int i = 0; i < 2000; ++i) {
    bar.run(&simulator, 1);
    largest = std::max(largest, std::abs(simulator.state().q[0]));
  }
  EXPECT_GT(largest, 0.1);  // the stop gives: v / w = 1 / (2 pi 10 Hz) = 16 mrad
  EXPECT_LT(largest, 0.1 + 0.016);
}

TEST(StiffServo, IsStableWhereTheExplicitOneIsNot) {
  Bar bar;
  bar.set_servo(1e6, 2e3);  // kd dt / I = 4: twice the explicit limit
  bar.command.q[0] = 0.1;
  Simulator implicit = bar.start(0.0, 0.0);
  bar.run(&implicit, 500);
  EXPECT_NEAR(implicit.state().q[0], 0.1, 1e-9);
  bar.scenario.integrator = "semi_implicit_euler";
  Simulator plain = bar.start(0.0, 0.0);
  StepStatus status = StepStatus::kOk;
  for (int i = 0; i < 500 && status == StepStatus::kOk; ++i) status = plain.step({}, bar.command);
  EXPECT_TRUE(status != StepStatus::kOk || std::abs(plain.state().q[0]) > 10.0);
}

TEST(EffectRegistry, RefusesParametersOutOfBoundsByName) {
  Bar bar;
  bar.add("coulomb_friction", {{"level", -1.0}});
  try {
    Simulator simulator(bar.robot, bar.scenario);
    FAIL();
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("bar_joint.coulomb_friction.level"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace hrp
