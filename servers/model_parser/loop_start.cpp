// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/loop_start.h"

#include <algorithm>
#include <cstdio>

#include "common/multibody/close_loops.h"
#include "common/robot/closed_chains.h"
#include "common/robot/sole.h"

namespace hrp {
namespace {

Diagnostic make_error(const LoopScan& loop, const std::string& file, const std::string& message) {
  Diagnostic d;
  d.file = file;
  d.line = loop.line;
  d.field = "loop '" + loop.spec.name + "'";
  d.message = message;
  return d;
}

// Where a loop of the merged scenario was written: in the description, or in the scenario.
Diagnostic make_loop_error(const std::vector<LoopScan>& described, const Scenario& scenario, const std::string& name,
                           const std::string& urdf_path, const std::string& message) {
  for (const LoopScan& loop : described) {
    if (loop.spec.name == name) return make_error(loop, urdf_path, message);
  }
  return scenario.make_diagnostic("loops." + name, message);
}

std::string print_gap(const LoopGap& gap, bool turns) {
  char text[80];
  std::snprintf(text, sizeof text, turns ? "%.3g mm and %.3g mrad" : "%.3g mm", 1e3 * gap.length, 1e3 * gap.angle);
  return text;
}

bool is_open(const LoopGap& gap) { return gap.length >= kOpenLoop || gap.angle >= kOpenLoop; }

// Passive joints whose positions nobody gave.
std::vector<int> find_movable(const TreeSpec& tree, const Scenario& scenario) {
  std::vector<int> joints = find_passive_joints(tree);
  joints.erase(std::remove_if(joints.begin(), joints.end(),
                              [&](int i) { return scenario.initial_joints.count(tree.joint(i).name) > 0; }),
               joints.end());
  return joints;
}

std::string join_names(const TreeSpec& tree, const std::vector<int>& joints) {
  std::string text;
  for (size_t k = 0; k < joints.size() && k < 6; ++k) text += (k > 0 ? ", " : "") + tree.joint(joints[k]).name;
  return text + (joints.size() > 6 ? ", ..." : "");
}

std::string describe_open(const LoopGap& zero, const LoopGap& start, bool turns, const std::string& movable) {
  std::string text = "is open by " + print_gap(start, turns) + " in the start pose";
  text += " and by " + print_gap(zero, turns) +
          " with all joints at zero, expected at most 5 mm and 5 mrad in the start pose; ";
  if (movable.empty()) {
    return text +
           "no joint may move to close it: mark those that no motor drives with <unactuated/>, or give closed "
           "positions in 'initial.joints'";
  }
  return text + "moving the passive joints (" + movable +
         ") does not close it: the origins do not fit, or 'initial.joints' must give a pose nearer by";
}

void write_pose(const State& state, const std::vector<int>& joints, const Scenario& scenario, RobotDescription* robot) {
  std::map<std::string, double> pose = scenario.initial_joints;
  for (int i : joints) {
    if (state.q[i] != 0.0) pose[robot->tree.joint(i).name] = state.q[i];
  }
  if (pose.size() > scenario.initial_joints.size()) robot->scenario = set_initial_joints(robot->scenario, pose);
}

}  // namespace

void merge_loops(const std::vector<LoopScan>& loops, const Scenario& scenario, const std::string& urdf_path,
                 RobotDescription* robot, Diagnostics* diagnostics) {
  std::vector<LoopSpec> added;
  for (const LoopScan& loop : loops) {
    added.push_back(loop.spec);
    for (const LoopSpec& own : scenario.loops) {
      if (own.name != loop.spec.name) continue;
      diagnostics->add_error(scenario.make_diagnostic(
          "loops." + own.name, "the robot's description has a loop of this name, too (" + urdf_path + ":" +
                                   std::to_string(loop.line) + "): loops of both count, expected another name"));
    }
  }
  if (!diagnostics->has_errors()) robot->scenario = add_loops(robot->scenario, added);
}

void close_start_pose(const std::vector<LoopScan>& loops, const Scenario& given, RobotDescription* robot,
                      Diagnostics* diagnostics) {
  const Scenario scenario = adopt_loops(given, robot->scenario);
  if (scenario.loops.empty()) return;
  const TreeSpec& tree = robot->tree;
  const Model model(tree, scenario.gravity_W);
  std::vector<LoopConstraint> constraints;
  for (size_t i = 0; i < scenario.loops.size(); ++i) {
    Scenario one = scenario;
    one.loops = {scenario.loops[i]};
    try {
      constraints.push_back(find_loops(tree, one)[0]);
    } catch (const InputError& error) {
      diagnostics->add_error(
          make_loop_error(loops, scenario, scenario.loops[i].name, robot->urdf_path, error.diagnostics()[0].message));
    }
  }
  if (diagnostics->has_errors()) return;
  State state = make_start_state(*robot, scenario), zero = state;
  zero.q.setZero();
  const std::vector<int> movable = find_movable(tree, scenario);
  const auto gaps_before = calc_gaps(model, constraints, state), gaps_zero = calc_gaps(model, constraints, zero);
  close_loops(model, constraints, movable, &state);
  const auto gaps = calc_gaps(model, constraints, state);
  for (size_t i = 0; i < gaps.size(); ++i) {
    const LoopSpec& loop = scenario.loops[i];
    if (!is_open(gaps[i])) continue;
    diagnostics->add_error(
        make_loop_error(loops, scenario, loop.name, robot->urdf_path,
                        describe_open(gaps_zero[i], gaps_before[i], loop.kind != "ball", join_names(tree, movable))));
  }
  if (!diagnostics->has_errors()) write_pose(state, movable, scenario, robot);
}

}  // namespace hrp
