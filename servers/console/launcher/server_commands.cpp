// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/launcher/server_commands.h"

#include <unistd.h>

#include <algorithm>
#include <climits>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "common/base/exact_number.h"
#include "common/base/has.h"
#include "common/node/node.h"
#include "common/robot/movers.h"
#include "servers/console/launcher/file_name.h"
#include "servers/model_parser/robot_loader.h"

namespace hrp {
namespace {

const char* get_default_program(const std::string& role) {
  if (role == "model_parser") return "hrp-model-parser";
  if (role == "scheduler") return "hrp-scheduler";
  if (role == "logger") return "hrp-logger";
  if (role == "dynamics") return "hrp-dynamics";
  if (role == "collision_checker") return "hrp-collision-checker";
  if (role == "vision") return "hrp-vision";
  return "hrp-controller";
}

std::string find_own_folder() {
  char path[PATH_MAX];
  const ssize_t size = readlink("/proc/self/exe", path, sizeof path);
  const std::string self(path, size > 0 ? static_cast<size_t>(size) : 0);
  return self.substr(0, self.find_last_of('/'));
}

// A name without a slash is a program of ours, beside this one.
std::string find_program(const std::string& name) {
  return name.find('/') == std::string::npos ? find_own_folder() + "/" + name : name;
}

std::string join_robots(const Scenario& scenario) {
  std::string names;
  for (const std::string& robot : list_robots(scenario)) names += (names.empty() ? "" : ",") + robot;
  return names;
}

std::vector<std::string> list_meshes(const RobotDescription& robot, bool visible) {
  std::vector<std::string> files;
  const auto add = [&files](const CollisionShape& shape) {
    if (!shape.mesh.empty()) files.push_back(shape.mesh);
  };
  if (!visible)
    std::for_each(robot.shapes.begin(), robot.shapes.end(), add);
  else
    for (const VisualShape& visual : robot.visuals) add(visual.shape);
  return files;
}

}  // namespace

std::string find_command(const std::string& name) {
  std::string own = find_program(name);
  const char* folders = std::getenv("PATH");
  if (access(own.c_str(), X_OK) == 0 || own == name || folders == nullptr) return own;
  std::istringstream list(folders);
  for (std::string folder; std::getline(list, folder, ':');) {
    std::string path = (folder.empty() ? "." : folder) + "/" + name;
    if (access(path.c_str(), X_OK) == 0) return path;
  }
  return own;
}

bool ServerCommands::is_left_out(const std::string& role) const { return has(options_.without, role); }

std::vector<int> ServerCommands::find_cores_of(const std::string& role, int domain) const {
  // Processes that take turns are fastest on one core: a wake-up across cores costs several times a switch on one.
  const std::vector<int> cores = find_cores();
  if (!options_.pin || cores.size() < 2) return {};
  const size_t loop_core = static_cast<size_t>(domain) % cores.size();  // runs side by side spread out
  const bool in_loop = role == "dynamics" || role == "collision_checker" || is_controller(role);
  std::vector<int> chosen;
  for (size_t i = 0; i < cores.size(); ++i) {
    if ((i == loop_core) == in_loop) chosen.push_back(cores[i]);
  }
  return chosen;
}

std::string ServerCommands::get_program(const std::string& role) const {
  const auto chosen = options_.programs.find(role);
  return chosen == options_.programs.end() ? get_default_program(role) : chosen->second;
}

std::string ServerCommands::get_vendor(const std::string& role) const {
  const auto chosen = options_.dds_for.find(role);
  return chosen == options_.dds_for.end() ? options_.dds : chosen->second;
}

// What a server of this run is told beside the place where it meets the others.
std::vector<std::string> ServerCommands::make_role_arguments(const std::string& role) const {
  std::vector<std::string> arguments;
  if (role == "model_parser") arguments.push_back(options_.scenario);
  if (role == "model_parser" && options_.verbose) arguments.push_back("--verbose");
  if (role == "dynamics" && options_.ros_rate > 0.0)
    arguments.insert(arguments.end(), {"--ros-rate", format_exact(options_.ros_rate)});
  if (role == "logger") arguments.insert(arguments.end(), {"--log", log_});
  if (role == "logger" && !scenario_.robots.empty())
    arguments.insert(arguments.end(), {"--robots", join_robots(scenario_)});
  if (!find_robot_of(role).empty()) arguments.insert(arguments.end(), {"--robot", find_robot_of(role)});
  if (role == "logger" && options_.force) arguments.push_back("--force");
  if (role == "logger" && options_.durable) arguments.push_back("--durable");
  if (role != "scheduler") return arguments;
  std::string waited_for = is_left_out("logger") ? "dynamics" : "dynamics,logger";
  if (scenario_.sensors.every_picture && is_needed("vision")) waited_for += ",vision";
  arguments.insert(arguments.end(), {"--wait-for", waited_for});
  arguments.insert(arguments.end(), {"--speed", format_exact(options_.speed)});
  if (options_.duration >= 0.0) arguments.insert(arguments.end(), {"--duration", format_exact(options_.duration)});
  if (options_.paused) arguments.push_back("--paused");
  if (options_.ros_services) arguments.push_back("--ros-services");
  return arguments;
}

ChildSpec ServerCommands::make_child(const std::string& role, const RunEntry& entry) const {
  ChildSpec child;
  child.role = role;
  const auto command = options_.commands.find(role);
  const bool is_command = command != options_.commands.end();
  auto& arguments = child.arguments;
  if (is_command) {
    arguments = command->second;
    arguments[0] = find_command(arguments[0]);
  } else {
    arguments = {find_program(get_program(role))};
  }
  arguments.insert(arguments.end(), {"--domain", std::to_string(entry.domain), "--dds", get_vendor(role)});
  // They then leave it to us to say what went wrong.
  const bool ours = options_.programs.count(role) == 0 && !is_command;
  if (ours) arguments.insert(arguments.end(), {"--parent", std::to_string(getpid())});
  if (!options_.secure.empty()) arguments.insert(arguments.end(), {"--secure", options_.secure});
  const std::vector<std::string> own = make_role_arguments(role);
  arguments.insert(arguments.end(), own.begin(), own.end());
  child.cores = find_cores_of(role, entry.domain);
  return child;
}

// Robot and scenario come over the bus. What comes from files are meshes and the motion that a controller plays.
std::vector<std::string> ServerCommands::find_files_of(const std::string& role) const {
  if (is_controller(role)) return find_motion(find_robot_of(role));
  if (role == "dynamics" && options_.programs.count(role) == 0) return {};
  const RobotDescription robot = load_robot(scenario_);
  std::vector<std::string> files = list_meshes(robot, role == "vision");
  for (const OtherRobot& other : robot.robots) {
    for (const std::string& file : list_meshes(other.description, role == "vision")) files.push_back(file);
  }
  return files;
}

// The file that a controller plays: of another robot, or of the first one (""). None or one.
std::vector<std::string> ServerCommands::find_motion(const std::string& robot) const {
  Scenario scenario = scenario_;
  for (const RobotPlacement& placement : scenario_.robots) {
    if (placement.name == robot) scenario = load_scenario(placement.scenario);
  }
  return scenario.controller.type == "motion" ? std::vector<std::string>{scenario.controller.motion}
                                              : std::vector<std::string>{};
}

RemoteCommand ServerCommands::make_remote(const std::string& role, const RunEntry& entry) const {
  RemoteCommand command;
  command.role = role;
  command.host = options_.on.at(role);
  command.token = entry.token;
  command.files = find_files_of(role);
  std::string path = get_program(role);
  if (path.find('/') == std::string::npos)
    path = (command.host.programs.empty() ? find_own_folder() : command.host.programs) + "/" + path;
  command.arguments = {path,
                       "--domain",
                       std::to_string(entry.domain),
                       "--dds",
                       get_vendor(role),
                       "--far-launcher",
                       "--network-interface",
                       turn_network(entry.network, find_address(command.host))};
  for (const std::string& word : make_role_arguments(role)) command.arguments.push_back(word);
  if (!options_.secure.empty()) {
    command.arguments.insert(
        command.arguments.end(),
        {"--secure",
         command.host.secure.empty() ? std::filesystem::absolute(options_.secure).string() : command.host.secure});
    command.files.push_back(command.arguments.back());
  }
  return command;
}

ChildSpec ServerCommands::make_viewer(const RunEntry& entry) const {
  ChildSpec child;
  child.role = "viewer";
  child.arguments = {find_program("hrp-viewer"),
                     "--domain",
                     std::to_string(entry.domain),
                     "--dds",
                     options_.dds,
                     "--port",
                     std::to_string(options_.view_port),
                     "--then",
                     log_};
  if (!options_.secure.empty()) child.arguments.insert(child.arguments.end(), {"--secure", options_.secure});
  return child;
}

std::string ServerCommands::make_join_command(const std::string& role) const {
  // The template of the tree: with our own controller there would have been no need to leave the place free.
  std::string command = find_own_folder() + "/" + (is_controller(role) ? "my-controller" : get_default_program(role));
  if (access(command.c_str(), X_OK) != 0) command = "scripts/build.sh " + get_file_name(command) + " && " + command;
  command += " --run " + std::to_string(getpid());
  if (!options_.secure.empty()) command += " --secure " + quote_word(options_.secure);
  for (const std::string& word : make_role_arguments(role)) command += " " + quote_word(word);
  return command;
}

}  // namespace hrp
