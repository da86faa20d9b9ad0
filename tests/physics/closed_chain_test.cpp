// SPDX-License-Identifier: BSD-3-Clause
// Closed chains in the step, against a linkage whose motion is known.
#include <gtest/gtest.h>

#include <cmath>

#include "common/multibody/kinematics.h"
#include "tests/physics/rigs.h"

namespace hrp {
namespace {

constexpr double kCrank = 0.3, kBase = 0.5;             // [m]
constexpr double kCrankMass = 0.8, kCouplerMass = 2.0;  // [kg]
constexpr double kCentre = 0.12, kCrankInertia = 0.01;  // [m], [kg m^2] about the crank's centre of mass
constexpr double kStart = 0.6;                          // [rad]

// Two equal cranks on the ground, joined by a coupler as long as the distance of their pivots: the coupler does not
// turn, so the linkage is one pendulum with J = 2 (I + m_c c^2) + m a^2 and weight lever 2 m_c c + m a.
RobotDescription make_parallelogram() {
  LinkInertia crank, coupler;
  crank.mass = kCrankMass;
  crank.p_LLcm_L = Vector3d(0, 0, -kCentre);
  crank.I_LLcm_L = kCrankInertia * Matrix3d::Identity();
  coupler.mass = kCouplerMass;
  coupler.p_LLcm_L = Vector3d(0.5 * kBase, 0, 0);
  coupler.I_LLcm_L = 0.05 * Matrix3d::Identity();
  RobotDescription robot = rigs::make_body(rigs::make_box_inertia(1.0, {0.1, 0.1, 0.1}));
  const int first = rigs::add_link(&robot, "first", 0, Vector3d::Zero(), Vector3d::UnitY(), crank);
  rigs::add_link(&robot, "coupler", first, Vector3d(0, 0, -kCrank), Vector3d::UnitY(), coupler);
  rigs::add_link(&robot, "second", 0, Vector3d(kBase, 0, 0), Vector3d::UnitY(), crank);
  return robot;
}

Scenario make_scenario(double dt) {
  Scenario scenario = rigs::make_scenario();
  scenario.floating_base = false;
  scenario.time_step = dt;
  scenario.initial_joints = {{"first_joint", kStart}, {"coupler_joint", -kStart}, {"second_joint", kStart}};
  LoopSpec loop;
  loop.name = "hinge";
  loop.link_a = "coupler";
  loop.link_b = "second";
  const Matrix3d turned = make_rotation_from_rpy({1.5707963267948966, 0, 0});  // z axis along the hinge
  loop.X_AF = {turned, Vector3d(kBase, 0, 0)};
  loop.X_BF = {turned, Vector3d(0, 0, -kCrank)};
  scenario.loops.push_back(loop);
  return scenario;
}

double calc_opening(const Simulator& simulator) {
  const Model model(simulator.tree());
  Data data(model);
  update_kinematics(model, simulator.state(), &data);
  const Vector3d a = get_pose(data, 2) * Vector3d(kBase, 0, 0), b = get_pose(data, 3) * Vector3d(0, 0, -kCrank);
  return (a - b).norm();
}

// Time of a quarter swing [s], and how far the hinge opened on the way [m].
void swing(double dt, double* time, double* opening) {
  Simulator simulator(make_parallelogram(), make_scenario(dt));
  const JointCommand command = rigs::make_command(simulator.state());
  *opening = 0.0;
  double before = kStart;
  for (int k = 0; k < 100000; ++k) {
    ASSERT_EQ(simulator.step({}, command), StepStatus::kOk) << simulator.fault_text();
    *opening = std::max(*opening, calc_opening(simulator));
    const double now = simulator.state().q[0];
    *time = simulator.time() - dt * now / (now - before);
    if (now <= 0.0) return;
    before = now;
  }
  FAIL() << "it never comes down";
}

TEST(ClosedChain, AParallelogramSwingsAsThePendulumItIs) {
  const double inertia = 2.0 * (kCrankInertia + kCrankMass * kCentre * kCentre) + kCouplerMass * kCrank * kCrank;
  const double rate = std::sqrt((2.0 * kCrankMass * kCentre + kCouplerMass * kCrank) * 9.81 / inertia);
  const double quarter = std::comp_ellint_1(std::sin(0.5 * kStart)) / rate;
  double coarse = 0.0, fine = 0.0, opening = 0.0;
  swing(1e-3, &coarse, &opening);
  EXPECT_LT(opening, 1e-4) << "[m] the hinge stays closed";
  swing(1e-4, &fine, &opening);
  EXPECT_LT(opening, 1e-5);
  EXPECT_NEAR(coarse / quarter, 1.0, 5e-3) << "first order: half a step's angle early or late";
  EXPECT_NEAR(fine / quarter, 1.0, 5e-4) << "ten times nearer with a tenth of the step";
}

// The coupler comes down on a floor without friction and rests there. Virtual work: N a = (2 m_c c + m a) g.
TEST(ClosedChain, RestsOnAFloorWithEveryContactModel) {
  for (const char* model_name : {"spring_damper", "wrench", "impulse"}) {
    Scenario scenario = make_scenario(1e-3);
    scenario.contact.model = model_name;
    Simulator simulator(make_parallelogram(), scenario);
    const Model model(simulator.tree());
    rigs::CornerFinder finder;
    finder.corners.push_back({2, Vector3d(0.5 * kBase, 0, 0)});
    finder.height = -kCrank * std::cos(0.3);
    finder.friction = 0.0;
    double opening = 0.0;
    for (int k = 0; k < 6000; ++k) {
      ASSERT_EQ(simulator.step(finder.find(model, simulator.state()), rigs::make_command(simulator.state())),
                StepStatus::kOk)
          << model_name << ", step " << k << ": " << simulator.fault_text();
      opening = std::max(opening, calc_opening(simulator));
    }
    EXPECT_LT(opening, 2e-4) << model_name;  // [m]; an impulse stops 0.5 m/s within a step
    EXPECT_LT(std::abs(simulator.state().qd[0]), 1e-4) << model_name;
    EXPECT_NEAR(simulator.state().q[0], 0.3, 2e-3) << model_name;
    ASSERT_FALSE(simulator.contact_forces().empty()) << model_name;
    const double force = (2.0 * kCrankMass * kCentre + kCouplerMass * kCrank) * 9.81 / kCrank;
    EXPECT_NEAR(simulator.contact_forces()[0].total[5] / force, 1.0, 1e-3) << model_name;
  }
}

TEST(ClosedChain, ThatIsOpenAtTheStartIsRefused) {
  Scenario scenario = make_scenario(1e-3);
  scenario.initial_joints["second_joint"] = kStart + 0.1;
  EXPECT_THROW(Simulator(make_parallelogram(), scenario), InputError);
}

TEST(ClosedChain, NamesTheLinkItDoesNotKnow) {
  Scenario scenario = make_scenario(1e-3);
  scenario.loops[0].link_b = "third";
  try {
    Simulator simulator(make_parallelogram(), scenario);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("third"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace hrp
