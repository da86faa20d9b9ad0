// SPDX-License-Identifier: BSD-3-Clause
// The biped with parallel ankles: its loops, from <loop> in the URDF, against MuJoCo, against virtual work, and under
// load.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "common/multibody/close_loops.h"
#include "common/multibody/kinematics.h"
#include "common/multibody/tree_mass.h"
#include "common/robot/closed_chains.h"
#include "common/spatial/gravity.h"
#include "servers/console/trial/trial.h"
#include "servers/dynamics/simulator.h"
#include "servers/model_parser/robot_loader.h"
#include "tests/engines/mujoco_engine.h"
#include "tests/test_places.h"
#include "tests/unit/multibody/random_tree.h"

namespace hrp {
namespace {

constexpr double kArm = 0.05, kHalfWidth = 0.04, kThigh = 0.36;  // [m] README.md of the robot

Scenario load() { return load_scenario(source_dir() + "/models/scenarios/parallel_ankles.yaml"); }

double get_q(const State& state, const TreeSpec& tree, const std::string& joint) {
  return state.q[tree.find_joint(joint)];
}

class Contact : public ::testing::TestWithParam<const char*> {};

// Largest gap of any loop [m], tried every 5 ms, how far the ankle was from its
// parallelogram, and how far it rolled [rad].
struct Watch {
  explicit Watch(const Trial& trial)
      : model(trial.robot().tree), loops(find_loops(trial.robot().tree, trial.scenario())) {}
  void look(const State& state) {
    for (const LoopGap& gap : calc_gaps(model, loops, state)) opening = std::max(opening, gap.length);
    const TreeSpec& tree = model.spec();
    for (const std::string side : {"L", "R"}) {
      const double cranks =
          0.5 * (get_q(state, tree, side + "_OUTER_MOTOR") + get_q(state, tree, side + "_INNER_MOTOR"));
      skew = std::max(skew, std::abs(get_q(state, tree, side + "_ANKLE_P") - cranks));
    }
    roll = std::max(roll, std::abs(get_q(state, tree, "L_ANKLE_R")));
    lowest = std::min(lowest, state.p_WB.z());
  }
  Model model;
  std::vector<LoopConstraint> loops;
  double opening = 0.0, skew = 0.0, roll = 0.0, lowest = 1e9;
};

TEST_P(Contact, TheBipedSquatsAndSwaysOnItsCranksAndItsLoopsStayClosed) {
  Scenario scenario = load();
  scenario.contact.model = GetParam();
  Trial trial(scenario);
  Watch watch(trial);
  ASSERT_EQ(watch.loops.size(), 4u) << "two rods an ankle";
  const double start = trial.engine().state().p_WB.z();
  long k = 0;
  const TrialResult result = trial.run([&](const Trial& t) {
    if (++k % 5 == 0) watch.look(t.engine().state());
  });
  EXPECT_EQ(result.fault, "");
  EXPECT_FALSE(result.fallen);
  EXPECT_NEAR(result.duration, 14.0, 1e-6);
  EXPECT_LT(result.largest_lean, 0.01) << "[rad]; the pelvis stays level, thigh and shank being equal";
  EXPECT_LT(watch.opening, 1e-6) << "[m]; 3e-8 measured: first-order steps of 1 ms, drift drawn back at 50 1/s";
  EXPECT_LT(watch.skew, 1e-3) << "[rad]; crank and foot arm are a parallelogram, but for the sine of 0.06 rad of roll";
  EXPECT_NEAR(watch.roll, 0.06, 0.004) << "[rad]; the sway; servos of the hips give by 2 mrad";
  const double depth = 2.0 * kThigh * (std::cos(0.3) - std::cos(0.8));
  EXPECT_NEAR(start - watch.lowest, depth, 0.005) << "[m] servos of 4000 N m/rad give by 5 mrad at the knee";
  EXPECT_NEAR(trial.engine().state().p_WB.z(), start, 0.005) << "and it stands again";
}

INSTANTIATE_TEST_SUITE_P(Models, Contact, ::testing::Values("spring_damper", "impulse", "wrench"));

// As a sensor below the ankle plate: what the rods carry is in it. Standing still, before the squats.
TEST(ParallelAnkles, AFootsForceSensorReadsJointAndRodsTogether) {
  Scenario scenario = load();
  scenario.duration = 0.9;
  Trial trial(scenario);
  trial.run();
  const std::vector<WrenchSample>& wrenches = trial.engine().sensors().wrenches;
  ASSERT_EQ(wrenches.size(), 2u);
  const double above = 0.5 * (calc_mass(trial.robot().tree) - 2.0 * 1.1) * kGravity;  // of a foot's 1.1 kg nothing
  EXPECT_NEAR(wrenches[0].force.z() / above, 1.0, 2e-3) << "[N]; still sinking in by 0.1 %";
  // The ankle joint has no drive and no friction: all moment goes through the rods, 0.05 m behind it.
  const TreeSpec& tree = trial.robot().tree;
  const SensorSample& read = trial.engine().sensors();
  const double cranks = read.effort[tree.find_joint("L_OUTER_MOTOR")] + read.effort[tree.find_joint("L_INNER_MOTOR")];
  // [N m] of cranks and rods; cranks are level
  const double weight = 9.81 * (2.0 * 0.12 * 0.5 * kArm + 2.0 * 0.11 * kArm);
  EXPECT_NEAR(cranks, -wrenches[0].torque.y() + weight, 0.01) << "[N m]; levers change by 0.1 % as servos give";
}

// What the loops do: the same robot without them has free ankles.
TEST(ParallelAnkles, WithoutItsRodsTheBipedFalls) {
  Scenario scenario = load();
  std::ifstream file(scenario.robot);
  std::string urdf((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  for (size_t at = urdf.find("<loop "); at != std::string::npos; at = urdf.find("<loop ")) {
    urdf.erase(at, urdf.find("</loop>", at) + 7 - at);
  }
  scenario.robot = ::testing::TempDir() + "/no_rods.urdf";
  std::ofstream(scenario.robot) << urdf;
  EXPECT_TRUE(Trial(scenario).run().fallen);
}

// Random angles on all joints that the scenario places would open the loops; passive joints close them again.
TEST(ParallelAnkles, StartClosedFromAVariedPose) {
  Scenario scenario = load();
  scenario.controller.type = "hold";
  scenario.initial_joints = {
      {"L_OUTER_MOTOR", -0.1}, {"L_INNER_MOTOR", -0.1}, {"R_OUTER_MOTOR", -0.1}, {"R_INNER_MOTOR", -0.1}};
  scenario.variation.pose = 0.02;
  const Trial trial(scenario);
  Watch watch(trial);
  watch.look(trial.engine().state());
  EXPECT_LT(watch.opening, 1e-10) << "[m]; Gauss-Newton ends at 1e-12 m";
  EXPECT_GT(watch.roll, 1e-3) << "the cranks differ by chance";
}

// The legs hang from a pelvis that is held, without weight; a couple [N m] in the foot's axes acts on the left foot.
// Efforts of the left outer and inner motor [N m] once all rests.
Eigen::Vector2d push_foot(const Vector3d& couple) {
  Scenario scenario = load();
  scenario.floating_base = false;
  scenario.gravity_W.setZero();
  scenario.initial_joints = {{"L_KNEE", 0.0}};  // all straight; the foot's axes are the world's
  scenario.controller.type = "hold";
  const RobotDescription robot = load_robot(scenario);
  Simulator simulator(robot, adopt_loops(scenario, robot.scenario));
  JointCommand command;
  command.q = simulator.state().q;
  ExternalWrench wrench;
  wrench.link = simulator.tree().find_link("L_FOOT");
  wrench.F_W << couple, Vector3d::Zero();
  for (int k = 0; k < 4000; ++k)
    EXPECT_EQ(simulator.step({}, command, {wrench}), StepStatus::kOk) << simulator.fault_text();
  const TreeSpec& tree = simulator.tree();
  return {simulator.joint_efforts()[tree.find_joint("L_OUTER_MOTOR")],
          simulator.joint_efforts()[tree.find_joint("L_INNER_MOTOR")]};
}

// Pitch turns both cranks as far as the foot. Roll by r lifts the rods' ends by +-half width r, which turns the cranks
// by half width / arm r, one up and one down. Efforts do no work with the couple.
TEST(ParallelAnkles, CouplesOnTheFootAreCarriedByTheCranksAsVirtualWorkSays) {
  const Eigen::Vector2d pitch = push_foot({0, 12, 0});
  EXPECT_NEAR(pitch.sum(), -12.0, 1e-3) << "at rest up to the servos' last micrometres";
  EXPECT_NEAR(pitch[0], pitch[1], 1e-3);
  const Eigen::Vector2d roll = push_foot({8, 0, 0});
  const double each = 0.5 * 8.0 * kArm / kHalfWidth;
  EXPECT_NEAR(std::abs(roll[0] - roll[1]), 2.0 * each, 0.01 * each)
      << "[N m]; the ankle gives by 4 mrad, the arms' cosines by less";
  EXPECT_NEAR(roll.sum(), 0.0, 0.01 * each);
  EXPECT_LT(roll[0], 0.0)
      << "the outer rod lies to the left: rolling to the right lifts it and draws its crank's end up";
}

// In poses with bent legs and turned cranks, at rest, with random efforts of the motors.
TEST(ParallelAnkles, AccelerateAsInMujocoWithConnectConstraints) {
  const Scenario scenario = load();
  const RobotDescription robot = load_robot(scenario);
  const TreeSpec& tree = robot.tree;
  const std::vector<LoopConstraint> constraints = find_loops(tree, adopt_loops(scenario, robot.scenario));
  const std::vector<int> passive = find_passive_joints(tree);
  std::vector<engines::BallTie> ties;
  for (const LoopConstraint& loop : constraints) ties.push_back({loop.link_a, loop.link_b, loop.X_AF.p});
  const Model model(tree);
  engines::MujocoEngine engine(tree, model.gravity_W(), ties);
  ASSERT_TRUE(engine.usable()) << engine.error();
  Data data(model);
  Loops loops(model, constraints);
  testing::Random random(3);
  Eigen::VectorXd vdot(model.nv()), open(model.nv());
  for (int i = 0; i < 20; ++i) {
    State state = make_state(model);
    state.q = random.values(model.num_joints(), 0.25);
    for (int j : passive) state.q[j] = 0.0;
    close_loops(model, constraints, passive, &state);
    for (const LoopGap& gap : calc_gaps(model, constraints, state)) ASSERT_LT(gap.length, 1e-10);
    Eigen::VectorXd effort = random.values(model.num_joints(), 20.0);
    for (int j : passive) effort[j] = 0.0;
    update_kinematics(model, state, &data);
    ASSERT_EQ(loops.calc_forward_dynamics(model, state, effort, nullptr, {}, &data, &vdot), Status::kOk);
    ASSERT_EQ(calc_forward_dynamics(model, effort, nullptr, {}, &data, &open), Status::kOk);
    engine.set_state(state);
    engine.set_effort(effort);
    engine.run_full_forward();
    EXPECT_LT(testing::relative_error(engine.get_acceleration(), vdot), 2e-3)
        << "pose " << i << "; MuJoCo's constraints are soft by 1e-4";
    EXPECT_GT(testing::relative_error(open, vdot), 0.1) << "and the loops matter";
  }
}

}  // namespace
}  // namespace hrp
