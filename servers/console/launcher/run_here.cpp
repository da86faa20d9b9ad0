// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cstdio>

#include "common/node/dynamics_loop.h"
#include "common/node/runner.h"
#include "common/robot/movers.h"
#include "controller/node.h"
#include "controller/play.h"
#include "servers/collision_checker/node.h"
#include "servers/console/launcher/monitor.h"
#include "servers/console/launcher/run_set.h"
#include "servers/dynamics/engine.h"
#include "servers/logger/node.h"
#include "servers/model_parser/node.h"
#include "servers/scheduler/node.h"
#include "servers/vision/node.h"

namespace hrp {
namespace {

SchedulerOptions make_scheduling(const LaunchOptions& options, const Scenario& scenario) {
  SchedulerOptions out;
  out.roles = {"dynamics", "logger"};
  if (scenario.sensors.every_picture && scenario.sensors.has_vision()) out.roles.push_back("vision");
  out.speed = options.speed;
  out.paused = options.paused;
  return out;
}

LoggerOptions make_logging(const LaunchOptions& options, const Scenario& scenario, const std::string& log) {
  LoggerOptions out;
  out.path = log;
  out.force = options.force;
  out.durable = options.durable;
  out.robots = list_robots(scenario);
  return out;
}

// `wall_time` [s] since the first step.
RunOutcome find_outcome(const RunMonitor& monitor, double wall_time) {
  const msg::RunStatus status = monitor.run_status();
  RunOutcome outcome;
  outcome.failure = status.phase() == msg::RUN_FAILED ? status.message() : "";
  if (!outcome.failure.empty()) {
    std::fprintf(stderr, "hrp-simulate: %s (at step %llu)\n", outcome.failure.c_str(),
                 static_cast<unsigned long long>(status.step()));
  }
  const bool refused = outcome.failure.rfind("model_parser: model refused", 0) == 0;
  outcome.exit_code = outcome.failure.empty() ? kExitOk : refused ? kExitBadInput : kExitFailed;
  outcome.wall_time = wall_time;
  outcome.parts = monitor.find_parts();
  outcome.logs = monitor.find_logs();
  return outcome;
}

}  // namespace

RunOutcome run_in_this_process(const LaunchOptions& options, const Scenario& scenario, const std::string& log) {
  using Clock = std::chrono::steady_clock;
  MemoryBus bus;
  RunMonitor monitor(bus, "", list_robots(scenario));
  const auto context = [&bus](const char* role) { return NodeContext{&bus, role, "hrp-simulate", "", ""}; };
  SchedulerNode scheduler(context("scheduler"), make_scheduling(options, scenario), options.duration);
  LoggerNode logger(context("logger"), make_logging(options, scenario, log));
  DynamicsLoop dynamics(context("dynamics"), make_simulator_engine);
  CollisionCheckerNode collision_checker(context("collision_checker"));
  ControllerNode controller(context("controller"), make_scenario_controller);
  std::vector<std::unique_ptr<ControllerNode>> others;
  for (const RobotPlacement& robot : scenario.robots) {
    NodeContext own = context("");
    own.role = make_controller_role(robot.name);
    own.robot = robot.name;
    others.push_back(std::make_unique<ControllerNode>(own, make_scenario_controller));
  }
  std::unique_ptr<VisionNode> vision;
  if (scenario.sensors.has_vision()) vision = std::make_unique<VisionNode>(context("vision"));
  ModelParserNode model_parser(context("model_parser"), options.scenario, options.verbose);

  ProgressLine progress(options.quiet);
  const auto start = Clock::now();
  std::vector<Node*> nodes{&scheduler, &logger, &dynamics, &collision_checker, &controller, &model_parser};
  for (const auto& other : others) nodes.push_back(other.get());
  if (vision) nodes.push_back(vision.get());
  run_in_process(nodes, bus, &scheduler, [&] {
    const msg::RunStatus status = monitor.run_status();
    for (const std::string& text : monitor.take_messages()) {
      progress.clear();
      std::fprintf(stderr, "%s\n", text.c_str());
    }
    progress.show(format_progress(status, scenario.feet, monitor.find_fall()));
  });
  progress.clear();
  return find_outcome(monitor, std::chrono::duration<double>(Clock::now() - monitor.find_first_step(start)).count());
}

}  // namespace hrp
