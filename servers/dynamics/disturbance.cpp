// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/disturbance.h"

#include <random>

#include "common/multibody/close_loops.h"
#include "common/robot/closed_chains.h"
#include "servers/dynamics/simulator.h"

namespace hrp {
namespace {

// Uniform in (-1, 1): made from the bits of the generator, because distributions of the standard library differ.
double draw(std::mt19937_64* generator) {
  return 2.0 * ((static_cast<double>((*generator)() >> 11) + 0.5) * 0x1.0p-53) - 1.0;
}

// Drives start where they were varied to; passive joints follow until the loops are closed.
void close_again(const RobotDescription& robot, Scenario* varied) {
  const Model model(robot.tree, varied->gravity_W);
  State state = make_initial_state(robot, *varied);
  const std::vector<int> joints = find_passive_joints(robot.tree);
  close_loops(model, find_loops(robot.tree, *varied), joints, &state);
  for (int i : joints) varied->initial_joints[robot.tree.joint(i).name] = state.q[i];
}

}  // namespace

RobotDescription vary_robot(const RobotDescription& robot, const Scenario& scenario) {
  RobotDescription varied = robot;
  if (scenario.variation.mass == 0.0) return varied;
  std::mt19937_64 generator(scenario.variation.seed);
  for (LinkSpec& link : varied.tree.links) {
    const double factor = 1.0 + scenario.variation.mass * draw(&generator);
    link.inertia.mass *= factor;
    link.inertia.I_LLcm_L *= factor;
  }
  return varied;
}

Scenario vary_scenario(const RobotDescription& robot, const Scenario& scenario) {
  Scenario varied = scenario;
  if (scenario.variation.pose == 0.0) return varied;
  std::mt19937_64 generator(scenario.variation.seed + 0x9E3779B97F4A7C15ull);
  for (int i = 0; i < robot.tree.num_joints(); ++i) {
    const auto found = varied.initial_joints.find(robot.tree.joint(i).name);
    if (found != varied.initial_joints.end()) found->second += scenario.variation.pose * draw(&generator);
  }
  if (!varied.loops.empty()) close_again(robot, &varied);
  return varied;
}

}  // namespace hrp
