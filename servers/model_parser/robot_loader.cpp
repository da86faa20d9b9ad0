// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/robot_loader.h"

#include <filesystem>
#include <map>

#include "common/base/read_file.h"
#include "common/robot/foot_bush.h"
#include "common/robot/movers.h"
#include "common/robot/scenario_check.h"
#include "common/robot/surface_file.h"
#include "controller/motion/motion.h"
#include "servers/model_parser/loop_start.h"
#include "servers/model_parser/mjcf/mjcf_robot.h"
#include "servers/model_parser/sdf/sdf_robot.h"
#include "servers/model_parser/sdf/sdf_world.h"
#include "servers/model_parser/urdf_scan.h"
#include "servers/model_parser/urdf_tree.h"
#include "servers/model_parser/urdf_visuals.h"

namespace hrp {
namespace {

// Without the warnings: they would hide why the robot is refused.
void throw_errors(const Diagnostics& diagnostics) {
  if (!diagnostics.has_errors()) return;
  Diagnostics errors;
  for (const Diagnostic& d : diagnostics.all()) {
    if (d.severity == Diagnostic::Severity::kError) errors.add_error(d);
  }
  throw InputError(errors);
}

// A run that plays a motion starts in the motion's first frame, unless the scenario says where: from another pose the
// servos would throw the robot up at once. The pose goes into the scenario as every server reads it.
void start_in_motion(const Scenario& scenario, RobotDescription* robot) {
  if (scenario.controller.type != "motion" || !scenario.initial_joints.empty()) return;
  const Motion motion = load_motion(scenario.controller.motion, scenario.controller.joint_order);
  std::map<std::string, double> start;
  for (size_t i = 0; i < motion.joints.size(); ++i) {
    if (robot->tree.find_joint(motion.joints[i]) >= 0)
      start[motion.joints[i]] = motion.positions(static_cast<Eigen::Index>(i), 0);
  }
  if (!start.empty()) robot->scenario = set_initial_joints(robot->scenario, start);
}

// Every server gets what the files hold, and reads none itself.
void load_surfaces(const Scenario& scenario, RobotDescription* robot, Diagnostics* diagnostics) {
  for (const ObstacleSpec& obstacle : scenario.obstacles) {
    if (!obstacle.is_surface()) continue;
    try {
      robot->surfaces.push_back(load_surface(obstacle));
    } catch (const InputError& error) {
      diagnostics->add_error(scenario.make_diagnostic("obstacles." + obstacle.name + ".file", error.what()));
    }
  }
}

// The scenario with what its world file adds, as every server will read it.
Scenario read_world(const Scenario& scenario) {
  if (scenario.world.empty()) return scenario;
  Diagnostics diagnostics;
  const WorldSpec world = read_sdf_world(read_input(scenario.world), scenario, &diagnostics);
  throw_errors(diagnostics);
  return parse_scenario(add_world(scenario.text, world), scenario.path);
}

// What was found in a URDF that was made from another format is said of that file's lines.
void add_with_source_lines(const Diagnostics& found, const UrdfText& urdf, const std::string& file,
                           Diagnostics* diagnostics) {
  for (Diagnostic d : found.all()) {
    const size_t line = static_cast<size_t>(d.line);
    const bool made = !urdf.source_lines.empty() && d.file == file && line > 0;
    if (made) d.line = line <= urdf.source_lines.size() ? urdf.source_lines[line - 1] : 0;
    diagnostics->add(d);
  }
}

// The robot's file as a URDF. Without source lines it is one.
UrdfText read_as_urdf(const std::string& text, const std::string& path, const Scenario& scenario,
                      Diagnostics* diagnostics) {
  const std::string format = find_root_element(text);
  if (format != "mujoco" && format != "sdf") return {text, {}};
  const BodyTree tree = format == "sdf" ? read_sdf(text, path, scenario.floating_base, diagnostics)
                                        : read_mjcf(text, path, scenario.floating_base, diagnostics);
  throw_errors(*diagnostics);
  return make_urdf(tree, std::filesystem::path(path).filename().string());
}

// Tree and shapes, from a URDF.
std::vector<LoopScan> read_tree(const UrdfText& urdf, const Scenario& scenario, RobotDescription* robot,
                                Diagnostics* diagnostics) {
  Diagnostics found;
  const UrdfScan scan = scan_urdf(urdf.text, robot->urdf_path, &found);
  if (!found.has_errors()) build_tree(scan, scenario, robot, &found);
  add_with_source_lines(found, urdf, robot->urdf_path, diagnostics);
  throw_errors(*diagnostics);
  return scan.loops;
}

// Its warnings go with those of the first robot.
void load_other_robot(const RobotPlacement& placement, const Scenario& world, RobotDescription* robot) {
  OtherRobot other;
  other.name = placement.name;
  Scenario own = load_scenario(placement.scenario);
  own.contact = world.contact;  // decides what a foot's bush is
  other.description = parse_robot(read_input(own.robot), own.robot, own);
  if (world.sensors.has_vision()) other.description.visuals = read_visuals(other.description.urdf, other.description);
  other.description.surfaces.clear();  // of its own world
  for (const std::string& warning : other.description.warnings)
    robot->warnings.push_back(placement.name + ": " + warning);
  robot->robots.push_back(std::move(other));
}

}  // namespace

RobotDescription parse_robot(const std::string& text, const std::string& path, const Scenario& scenario) {
  Diagnostics diagnostics;
  const UrdfText urdf = read_as_urdf(text, path, scenario, &diagnostics);
  RobotDescription robot;
  robot.urdf_path = path;
  robot.urdf = urdf.text;
  robot.scenario_path = scenario.path;
  robot.scenario = scenario.text;
  const std::vector<LoopScan> loops = read_tree(urdf, scenario, &robot, &diagnostics);
  check_scenario(scenario, robot, &diagnostics);
  if (scenario.robots.empty()) check_pushes(scenario, robot, &diagnostics);
  throw_errors(diagnostics);
  load_surfaces(scenario, &robot, &diagnostics);
  throw_errors(diagnostics);
  if (scenario.sensors.has_vision()) robot.visuals = read_visuals(urdf.text, robot);
  insert_foot_bushes(scenario, &robot);
  merge_loops(loops, scenario, path, &robot, &diagnostics);
  throw_errors(diagnostics);
  start_in_motion(scenario, &robot);
  close_start_pose(loops, scenario, &robot, &diagnostics);
  throw_errors(diagnostics);
  robot.warnings = diagnostics.warning_texts();
  return robot;
}

RobotDescription load_robot(const Scenario& scenario) {
  const Scenario in_world = read_world(scenario);
  RobotDescription robot = parse_robot(read_input(in_world.robot), in_world.robot, in_world);
  for (const RobotPlacement& placement : in_world.robots) load_other_robot(placement, in_world, &robot);
  if (in_world.robots.empty()) return robot;
  Diagnostics diagnostics;
  check_pushes(in_world, robot, &diagnostics);
  throw_errors(diagnostics);
  make_movers(robot, in_world);  // throws where robots do not go together
  return robot;
}

}  // namespace hrp
