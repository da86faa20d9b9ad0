// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/launcher/options.h"

#include <cstdio>

#include <CLI/CLI.hpp>

#include "common/base/diagnostics.h"
#include "common/base/has.h"
#include "common/base/shared_files.h"
#include "common/base/version.h"
#include "common/bus/make_bus.h"
#include "common/node/join.h"
#include "common/node/node.h"
#include "common/node/ros_views.h"
#include "common/node/runner.h"
#include "servers/scheduler/step_scheduler.h"

namespace hrp {
namespace {

const char kFooter[] = R"(Examples:
  hrp-simulate models/scenarios/default.yaml
  hrp-simulate S.yaml --dds fast --duration 5 --log run.mcap
  hrp-simulate S.yaml --dds-for controller=fast          one server on the other vendor
  hrp-simulate S.yaml --view                             shows the run in the browser
  hrp-simulate S.yaml --without controller               waits for a controller of your own
  hrp-simulate S.yaml --controller "python3 python/examples/my_controller.py"     starts a controller of your own
  hrp-simulate S.yaml --controller-of partner=my-controller      the same for another robot of the scenario
  hrp-simulate S.yaml --on controller=robot              the controller on another machine, over ssh
  hrp-simulate S.yaml --program dynamics=hrp-dynamics-mujoco

While it runs, from a second terminal:
  hrp-run pause | run | step 10 | reset | stop | status --follow
  hrp-topic list | echo hrp/contact_forces

Exit status: 0 the run ended as planned or was stopped (Ctrl-C, hrp-run stop); 1 a server failed; 2 scenario, model or
command line cannot be used.)";

const std::vector<std::string> kRoles{"model_parser",      "scheduler",  "logger", "dynamics",
                                      "collision_checker", "controller", "vision"};

// Which robots there are is known when the scenario is read: check_robots().
std::string find_role_fault(const std::string& role) {
  if (has(kRoles, role) || !find_robot_of(role).empty()) return "";
  return "there is no server '" + role + "'; the servers are " + CLI::detail::join(kRoles, ", ") +
         ", and controller.ROBOT of other robots";
}

// "role=value" for a known role.
std::map<std::string, std::string> split_pairs(const std::vector<std::string>& words, const std::string& option) {
  std::map<std::string, std::string> pairs;
  for (const std::string& word : words) {
    const size_t equals = word.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == word.size()) {
      throw CLI::ValidationError(option, "'" + word + "' is not SERVER=VALUE");
    }
    const std::string role = word.substr(0, equals);
    const std::string fault = find_role_fault(role);
    if (!fault.empty()) throw CLI::ValidationError(option, fault);
    pairs[role] = word.substr(equals + 1);
  }
  return pairs;
}

// As a shell splits it at blanks; quotes and backslashes keep words together.
std::vector<std::string> split_command(const std::string& command, const std::string& option) {
  std::vector<std::string> words;
  bool in_word = false;
  char quote = 0;
  for (size_t i = 0; i < command.size(); ++i) {
    const char c = command[i];
    if (quote == 0 && (c == ' ' || c == '\t')) {
      in_word = false;
      continue;
    }
    if (!in_word) words.emplace_back();
    in_word = true;
    if (c == quote) {
      quote = 0;
    } else if (quote == 0 && (c == '"' || c == '\'')) {
      quote = c;
    } else {
      words.back() += c == '\\' && quote != '\'' && i + 1 < command.size() ? command[++i] : c;
    }
  }
  if (words.empty() || quote != 0) throw CLI::ValidationError(option, "'" + command + "' is no command");
  return words;
}

// What cannot go together with servers on other machines.
void check_hosts(const LaunchOptions& options) {
  if (options.on.empty()) return;
  const auto refuse = [](const std::string& why) { throw CLI::ValidationError("--on", why); };
  if (options.in_process) refuse("excludes --in-process: all servers are in one process");
  if (options.keep_going) refuse("excludes --keep-going: a server on another machine is not started again");
  for (const auto& [role, words] : options.commands) {
    if (options.on.count(role) > 0)
      refuse(role + ": excludes a command in its place, which knows nothing of a launcher on another machine");
  }
  for (const auto& [role, host] : options.on) {
    const auto& without = options.without;
    if (has(without, role)) refuse(role + ": excludes --without " + role);
  }
}

// What the command line says in words of its own.
struct Words {
  bool realtime = false, no_pin = false, no_plot = false;
  std::vector<std::string> dds_for, programs, controllers, on;
  std::string controller, hosts, ssh = "ssh";
};

// Scenario, bus, time, and what is kept of the run.
void add_run_options(CLI::App* app, Words* words, LaunchOptions* options) {
  app->add_option("SCENARIO", options->scenario,
                  "scenario file (YAML), or the name of an installed one: default, squat, paper_a/fig9")
      ->required();
  app->add_option("--dds", options->dds, "DDS of all servers")
      ->check(CLI::IsMember({"cyclone", "fast"}))
      ->capture_default_str();
  app->add_option("--dds-for", words->dds_for, "SERVER=cyclone|fast: DDS of one server; may be repeated");
  app->add_option("--duration", options->duration, "[s] of simulated time, 0 = until stopped; default: the scenario's")
      ->check([](const std::string& word) { return find_duration_fault(std::strtod(word.c_str(), nullptr)); });
  app->add_flag("--in-process", options->in_process, "all servers in one process and thread, without DDS");
  app->add_flag("--realtime", words->realtime, "at most real time (= --speed 1)");
  app->add_option("--speed", options->speed, "at most this many simulated seconds per second; 0 = no limit")
      ->check([](const std::string& word) { return find_speed_fault(std::strtod(word.c_str(), nullptr)); });
  app->add_option("--ros-rate", options->ros_rate,
                  "[Hz of simulated time] rate of /joint_states and /tf for ROS 2; 0 = every control period")
      ->check([](const std::string& word) { return find_ros_rate_fault(std::strtod(word.c_str(), nullptr)); });
  app->add_flag(
      "--ros-services", options->ros_services,
      "offers the ROS 2 services /run/pause, /run/resume, /run/step, /run/reset to anybody who reaches the domain");
  app->add_option("--log", options->log, "log file (MCAP); default: the scenario's, else logs/SCENARIO-TIME.mcap");
  app->add_flag("--force", options->force, "overwrite an existing log");
  app->add_flag("--durable", options->durable,
                "flush each part of the log to the disk: a power cut loses no step that counts as logged");
}

// Which programs are its servers, and where they run.
void add_server_options(CLI::App* app, Words* words, LaunchOptions* options) {
  app->add_option("--without", options->without, "do not start this server: you start it yourself; may be repeated")
      ->check(find_role_fault);
  app->add_option("--program", words->programs,
                  "SERVER=PROGRAM: replaces a server by another program; may be repeated");
  app->add_option(
      "--controller", words->controller,
      "command that replaces our controller, such as my-controller or \"python3 python/examples/my_controller.py\"");
  app->add_option("--controller-of", words->controllers,
                  "ROBOT=COMMAND: the same for another robot of the scenario; may be repeated");
  app->add_option("--on", words->on,
                  "SERVER=[USER@]HOST: start this server on another machine, over ssh; may be repeated");
  app->add_option(
         "--hosts", words->hosts,
         "file with one line \"SERVER HOST [address=] [user=] [programs=] [secure=]\" per server on another machine")
      ->check(CLI::ExistingFile);
  app->add_option("--ssh", words->ssh,
                  "command that runs a program on another machine, such as \"ssh -p 2222\" or \"ip netns exec\"")
      ->capture_default_str();
}

// How it runs, and what is seen of it.
void add_other_options(CLI::App* app, Words* words, LaunchOptions* options) {
  app->add_flag("--paused", options->paused, "wait for hrp-run before the first step");
  app->add_flag("--keep-going", options->keep_going, "restart a server that died, instead of ending the run");
  app->add_option("--domain", options->domain, "DDS domain; default: a free one")->check(CLI::Range(0, 230));
  app->add_option("--secure", options->secure, "folder of identities (scripts/secure.sh makes it): only these may join")
      ->check(CLI::ExistingDirectory);
  app->add_flag("--no-pin", words->no_pin, "let the kernel choose the core of each server");
  app->add_flag("--no-plot", words->no_plot, "no plot of the contact forces at the end");
  app->add_flag("--view", options->view,
                "prints the address of a page that shows the run; real time unless --speed is given");
  app->add_option("--view-port", options->view_port, "port of the page; default: a free one")
      ->check(CLI::Range(0, 65535));
  app->add_flag("--verbose", options->verbose, "every warning about the robot in full");
  app->add_flag("--quiet", options->quiet, "no progress line");
}

void take_words(const Words& words, LaunchOptions* options) {
  options->scenario = find_scenario_file(options->scenario);
  options->dds_for = split_pairs(words.dds_for, "--dds-for");
  options->programs = split_pairs(words.programs, "--program");
  if (!words.controller.empty()) options->commands["controller"] = split_command(words.controller, "--controller");
  for (const std::string& word : words.controllers) {
    const auto [role, command] = *split_pairs({make_controller_role(word)}, "--controller-of").begin();
    options->commands[role] = split_command(command, "--controller-of");
  }
  if (!words.hosts.empty()) options->on = read_hosts(words.hosts);
  for (const std::string& word : words.on) {
    const auto [role, host] = parse_on(word);
    options->on[role] = host;
  }
  options->ssh = make_ssh_command(split_command(words.ssh, "--ssh"));
  options->pin = !words.no_pin;
  options->plot = !words.no_plot;
}

void check_commands(const LaunchOptions& options) {
  for (const auto& [role, words] : options.commands) {
    const bool left_out = has(options.without, role);
    if (!left_out && options.programs.count(role) == 0) continue;
    throw CLI::ValidationError(role == "controller" ? "--controller" : "--controller-of",
                               "excludes --without " + role + " and --program " + role + "=...");
  }
}

void check_vendors(const LaunchOptions& options) {
  for (const auto& [role, vendor] : options.dds_for) {
    if (vendor != "cyclone" && vendor != "fast")
      throw CLI::ValidationError("--dds-for", vendor + " is no DDS: cyclone or fast");
    if (!options.secure.empty() && vendor != options.dds) throw CLI::ValidationError("--dds-for", kNoSecureMix);
  }
}

// All servers in one process have no bus: what is of it, or of other processes on it, cannot go together with that.
void check_in_process(const CLI::App& app, const LaunchOptions& options) {
  if (!options.in_process) return;
  const auto refuse = [](const std::string& why) { throw CLI::ValidationError("--in-process", "excludes " + why); };
  if (app.count("--dds") > 0) refuse("--dds: all servers are in one process, there is no bus between them");
  if (!options.secure.empty()) refuse("--secure: there is no bus that others could join");
  if (app.count("--ros-rate") > 0) refuse("--ros-rate: there is no bus that others could read");
  if (options.ros_services) refuse("--ros-services: there is no bus that others could call over");
  if (options.view) refuse("--view: the viewer is a process of its own on the bus");
  if (!(options.without.empty() && options.programs.empty() && options.dds_for.empty() && options.commands.empty()))
    refuse("--without, --program, --controller, --controller-of and --dds-for: there is nobody to join");
}

}  // namespace

std::vector<std::string> list_roles(const Scenario& scenario) {
  std::vector<std::string> roles;
  for (const std::string& role : kRoles) {
    roles.push_back(role);
    if (role != "controller") continue;
    for (const RobotPlacement& robot : scenario.robots) roles.push_back(make_controller_role(robot.name));
  }
  return roles;
}

void check_robots(const LaunchOptions& options, const Scenario& scenario) {
  const std::vector<std::string> roles = list_roles(scenario);
  const auto check = [&](const std::string& option, const std::string& role) {
    if (has(roles, role)) return;
    throw InputError(
        scenario.make_diagnostic("robots", "has no robot '" + find_robot_of(role) + "', which " + option + " names" +
                                               (scenario.robots.empty() ? "; the scenario has one robot" : "")));
  };
  for (const auto& [role, program] : options.programs) check("--program", role);
  for (const auto& [role, words] : options.commands) check("--controller-of", role);
  for (const auto& [role, vendor] : options.dds_for) check("--dds-for", role);
  for (const auto& [role, host] : options.on) check("--on", role);
  for (const std::string& role : options.without) check("--without", role);
}

void leave_out_absent_controllers(const Scenario& scenario, LaunchOptions* options) {
  if (scenario.controller.type == "none") options->without.push_back("controller");
  for (const RobotPlacement& robot : scenario.robots) {
    if (load_scenario(robot.scenario).controller.type == "none")
      options->without.push_back(make_controller_role(robot.name));
  }
}

bool parse_launch_options(int argc, char** argv, LaunchOptions* options, int* exit_code) {
  CLI::App app("Runs a scenario: starts the servers, shows progress and errors, and prints where the log is.",
               "hrp-simulate");
  app.set_version_flag("--version", get_version_text("hrp-simulate"));
  app.footer(kFooter);
  Words words;
  add_run_options(&app, &words, options);
  add_server_options(&app, &words, options);
  add_other_options(&app, &words, options);
  try {
    app.parse(argc, argv);
    take_words(words, options);
    check_hosts(*options);
    check_commands(*options);
    check_vendors(*options);
    check_in_process(app, *options);
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error) == 0 ? kExitOk : kExitBadInput;
    return false;
  } catch (const InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    *exit_code = kExitBadInput;
    return false;
  }
  const bool watched = options->view && app.count("--speed") == 0;
  if ((words.realtime || watched) && options->speed == 0.0) options->speed = 1.0;
  return true;
}

}  // namespace hrp
