// SPDX-License-Identifier: BSD-3-Clause
// Motion without contact against closed forms; drift and order of each integrator.
#include <gtest/gtest.h>

#include "common/multibody/kinematics.h"
#include "common/multibody/momentum.h"
#include "tests/physics/rigs.h"
#include "tests/physics/solutions/dynamics_solutions.h"

namespace hrp {
namespace {

const char* const kIntegrators[] = {"implicit", "semi_implicit_euler", "rk4"};

void run(Simulator* simulator, double time) {
  const JointCommand command = rigs::make_command(simulator->state());
  const auto steps = static_cast<long>(std::lround(time / simulator->time_step()));
  for (long i = 0; i < steps; ++i) {
    ASSERT_EQ(simulator->step({}, command), StepStatus::kOk) << simulator->fault_text();
  }
}

Simulator make_simulator(const RobotDescription& robot, const std::string& integrator, double dt, bool floating,
                         double gravity) {
  Scenario scenario = rigs::make_scenario();
  scenario.integrator = integrator;
  scenario.time_step = dt;
  scenario.floating_base = floating;
  scenario.gravity_W = Vector3d(0, 0, -gravity);
  return Simulator(robot, scenario);
}

TEST(FreeFall, FallsByHalfGravityTimesTimeSquared) {
  for (const char* integrator : kIntegrators) {
    Simulator simulator =
        make_simulator(rigs::make_body(rigs::make_box_inertia(2.0, {0.1, 0.2, 0.3})), integrator, 0.001, true, 9.81);
    run(&simulator, 1.0);
    // Euler's sum is g dt^2 n (n + 1) / 2, known to rounding; Runge-Kutta is exact for parabolas.
    const double euler = 9.81 * 0.5 * 1.0 * (1.0 + 0.001);
    const double fallen = std::string(integrator) == "rk4" ? 9.81 * 0.5 : euler;
    EXPECT_NEAR(-simulator.state().p_WB.z(), fallen, 1e-11) << integrator;
    EXPECT_NEAR(simulator.state().V_WB[5], -9.81, 1e-11) << integrator;
  }
}

RobotDescription make_double_pendulum(const solutions::DoublePendulum& s) {
  RobotDescription robot = rigs::make_body(rigs::make_box_inertia(1.0, {0.1, 0.1, 0.1}));
  LinkInertia one, two;
  one.mass = s.mass1;
  one.p_LLcm_L = Vector3d(0, 0, -s.length1);
  two.mass = s.mass2;
  two.p_LLcm_L = Vector3d(0, 0, -s.length2);
  rigs::add_link(&robot, "upper", 0, Vector3d::Zero(), Vector3d::UnitY(), one);
  rigs::add_link(&robot, "lower", 1, Vector3d(0, 0, -s.length1), Vector3d::UnitY(), two);
  return robot;
}

double calc_pendulum_error(const char* integrator, double dt) {
  const solutions::DoublePendulum pendulum;
  Simulator simulator = make_simulator(make_double_pendulum(pendulum), integrator, dt, false, pendulum.gravity);
  State state = simulator.state();
  state.q << 1.0, 0.5;
  state.qd << -0.3, 0.8;
  EXPECT_TRUE(simulator.reset(state));
  run(&simulator, 0.512);
  const auto truth = solutions::integrate_double_pendulum(pendulum, {1.0, 0.5, -0.3, 0.8}, 0.512);
  return std::abs(simulator.state().q[0] - truth[0]) + std::abs(simulator.state().q[1] - truth[1]);
}

TEST(DoublePendulum, FollowsTheReferenceSolution) {
  EXPECT_LT(calc_pendulum_error("rk4", 0.001), 1e-10);
  EXPECT_LT(calc_pendulum_error("implicit", 0.00025), 5e-3);
}

TEST(DoublePendulum, ConvergesWithTheOrderOfEachIntegrator) {
  for (const char* integrator : kIntegrators) {
    const bool fourth = std::string(integrator) == "rk4";
    const double dt = fourth ? 0.016 : 0.001;
    const double order = std::log2(calc_pendulum_error(integrator, dt) / calc_pendulum_error(integrator, dt / 2));
    EXPECT_NEAR(order, fourth ? 4.0 : 1.0, fourth ? 0.4 : 0.2) << integrator;
  }
}

TEST(SymmetricTop, PrecessesAtTheClosedFormRate) {
  LinkInertia inertia;
  inertia.mass = 1.0;
  inertia.I_LLcm_L = Vector3d(0.02, 0.02, 0.03).asDiagonal();
  Simulator simulator = make_simulator(rigs::make_body(inertia), "rk4", 0.001, true, 0.0);
  State state = simulator.state();
  const Vector3d w(1.0, 0.3, 6.0);
  state.V_WB.head<3>() = w;
  ASSERT_TRUE(simulator.reset(state));
  run(&simulator, 2.0);
  const Vector3d rate = simulator.state().R_WB.conjugate() * Vector3d(simulator.state().V_WB.head<3>());
  EXPECT_LT((rate - solutions::calc_symmetric_top_rate(0.02, 0.03, w, 2.0)).norm(), 1e-9);
}

// Relative drift of [energy, angular momentum] of a free asymmetric body after 5 s.
std::pair<double, double> calc_drift(const char* integrator, double dt) {
  LinkInertia inertia = rigs::make_box_inertia(3.0, {0.1, 0.2, 0.4}, {0.02, -0.01, 0.03});
  Simulator simulator = make_simulator(rigs::make_body(inertia), integrator, dt, true, 0.0);
  State state = simulator.state();
  state.V_WB << 1.0, 3.0, 0.5, 0.2, -0.1, 0.3;
  EXPECT_TRUE(simulator.reset(state));
  const Model model(simulator.tree(), Vector3d::Zero());
  Data data(model);
  const auto measure = [&](double* energy, Vector3d* momentum) {
    update_kinematics(model, simulator.state(), &data);
    *energy = calc_kinetic_energy(model, data);
    *momentum = calc_centroidal_momentum(model, data).head<3>();
  };
  double e0 = 0, e1 = 0;
  Vector3d h0, h1;
  measure(&e0, &h0);
  run(&simulator, 5.0);
  measure(&e1, &h1);
  return {std::abs(e1 / e0 - 1.0), (h1 - h0).norm() / h0.norm()};
}

TEST(AsymmetricBody, KeepsEnergyAndMomentumToTheOrderOfTheIntegrator) {
  const auto fourth = calc_drift("rk4", 0.001);
  EXPECT_LT(fourth.first, 1e-9);
  EXPECT_LT(fourth.second, 1e-9);
  for (const char* integrator : {"implicit", "semi_implicit_euler"}) {
    const auto coarse = calc_drift(integrator, 0.001), fine = calc_drift(integrator, 0.0005);
    EXPECT_LT(coarse.first, 0.05) << integrator;
    EXPECT_NEAR(coarse.first / fine.first, 2.0, 0.3) << integrator;
    EXPECT_NEAR(coarse.second / fine.second, 2.0, 0.3) << integrator;
  }
}

TEST(SpringMass, OscillatesAsTheClosedFormSays) {
  RobotDescription robot = rigs::make_body(rigs::make_box_inertia(1.0, {0.1, 0.1, 0.1}));
  rigs::add_link(&robot, "slider", 0, Vector3d::Zero(), Vector3d::UnitX(),
                 rigs::make_box_inertia(2.0, {0.1, 0.1, 0.1}));
  robot.tree.joint(0).kind = JointKind::kPrismatic;
  robot.tree.joint(0).actuated = false;
  robot.tree.joint(0).spring = {200.0, 3.0, 0.0};
  for (const char* integrator : kIntegrators) {
    Simulator simulator = make_simulator(robot, integrator, 1e-4, false, 0.0);
    State state = simulator.state();
    state.q[0] = 0.1;
    ASSERT_TRUE(simulator.reset(state));
    run(&simulator, 1.0);
    const double truth = solutions::calc_damped_oscillation(2.0, 3.0, 200.0, 0.1, 1.0);
    // First order: implicit Euler damps by w^2 dt / 2 per second = 5e-3 of the amplitude.
    EXPECT_NEAR(simulator.state().q[0], truth, std::string(integrator) == "rk4" ? 1e-12 : 1e-3) << integrator;
  }
}

}  // namespace
}  // namespace hrp
