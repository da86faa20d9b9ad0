// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/scenario.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "common/base/exact_number.h"
#include "common/base/printable.h"
#include "common/base/read_file.h"
#include "common/robot/effect_section.h"
#include "common/robot/scenario_sections.h"
#include "common/robot/vision_section.h"
#include "common/robot/yaml_map.h"

namespace hrp {
namespace {

namespace fs = std::filesystem;

// Absolute form of `name`, which stands in a file of folder `folder`.
std::string make_absolute(const std::string& name, const fs::path& folder) {
  if (name.empty()) return name;
  const fs::path path(name);
  std::error_code error;
  const fs::path absolute = fs::absolute(path.is_absolute() ? path : folder / path, error);
  return (error ? path : absolute).lexically_normal().string();
}

std::string format_number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.10g", value);
  return text;
}

// Number of steps in `period`, 0 after a complaint. 1e-9: periods are decimal numbers that binary ones only
// approximate.
int calc_steps(YamlMap& map, const std::string& key, double period, double time_step) {
  const double ratio = period / time_step;
  const double rounded = std::round(ratio);
  if (rounded >= 1.0 && rounded < 1e9 && std::abs(ratio - rounded) <= 1e-9 * rounded) return static_cast<int>(rounded);
  const double below = std::max(1.0, std::floor(ratio));
  map.error(key, "is " + format_number(period) + " s" + (map.has(key) ? "" : " (the default)") +
                     ", expected a multiple of steps.time_step " + format_number(time_step) + " s, such as " +
                     format_number(below * time_step) + " or " + format_number((below + 1.0) * time_step));
  return 0;
}

void read_steps(YamlMap& map, Scenario* scenario) {
  double control_period = 0.005;
  map.number("time_step", &scenario->time_step, Bound::kPositive, "s");
  map.number("control_period", &control_period, Bound::kPositive, "s");
  map.number("duration", &scenario->duration, Bound::kNotNegative, "s");
  if (scenario->time_step > 0.1)
    map.error("time_step", "is " + format_number(scenario->time_step) + " s, expected at most 0.1 s");
  if (control_period > 1.0)
    map.error("control_period", "is " + format_number(control_period) + " s, expected at most 1 s");
  const int steps = calc_steps(map, "control_period", control_period, scenario->time_step);
  if (steps > 0) scenario->control_period = steps;
}

void read_all(YamlMap& map, Scenario* scenario) {
  map.require("robot", "the path of a URDF file");
  map.text("robot", &scenario->robot);
  std::string base = "floating";
  map.choice("base", &base, {"fixed", "floating"});
  scenario->floating_base = base == "floating";
  map.choice("drive", &scenario->drive, {"servo", "effort", "motion", "voltage"});
  map.vector3("gravity", &scenario->gravity_W, Bound::kAny, "m/s^2");
  read_world_sections(map, scenario);
  read_joint_sections(map, scenario);
  read_sensor_sections(map, scenario);
  if (map.has("steps")) {
    map.child("steps", [&](YamlMap& child) { read_steps(child, scenario); });
  }
  read_effect_sections(map, scenario);
  if (scenario->drive == "voltage") {  // by now a servo with a back-EMF: read_joint_sections()
    if (scenario->servo_joints.empty())
      map.error("drive", "is voltage, but 'servo.joints' names no joint with supply, resistance and torque_constant");
    scenario->drive = "servo";
    scenario->servo_default = {};  // volts were for the joints that are named
  }
  map.choice("integrator", &scenario->integrator, {"implicit", "semi_implicit_euler", "rk4"});
  map.choice("interpolation", &scenario->interpolation, {"hold", "linear", "hermite"});
  map.flag("repair_inertias", &scenario->repair_inertias);
  map.integer("seed", &scenario->seed);
  // Keys of experiment folders that describe recordings; a simulation has no use for them.
  for (const char* key : {"recordings", "columns", "topics", "noise", "sample_rate", "unknown_force", "feet_attached",
                          "name", "description", "notes"}) {
    map.ignore(key);
  }
  map.finish();
}

void resolve_paths(Scenario* scenario) {
  const fs::path folder = fs::path(scenario->path).parent_path();
  scenario->robot = make_absolute(scenario->robot, folder);
  scenario->controller.motion = make_absolute(scenario->controller.motion, folder);
  scenario->world = make_absolute(scenario->world, folder);
  for (ObstacleSpec& obstacle : scenario->obstacles) obstacle.file = make_absolute(obstacle.file, folder);
  for (RobotPlacement& robot : scenario->robots) robot.scenario = make_absolute(robot.scenario, folder);
}

void check_file(const Scenario& scenario, const std::string& key, const std::string& path, Diagnostics* diagnostics) {
  std::error_code error;
  if (path.empty() || fs::is_regular_file(path, error)) return;
  diagnostics->add_error(scenario.make_diagnostic(key, "there is no file '" + path + "'"));
}

YAML::Node parse_yaml(const std::string& text, const std::string& path) {
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    refuse_input(make_place(path, error.mark), "not valid YAML: " + error.msg);
  } catch (const std::bad_alloc&) {
    throw;                                 // not the file's fault
  } catch (const std::exception& error) {  // yaml-cpp lets a few std exceptions through on malformed text
    refuse_input(path, std::string("not valid YAML: ") + error.what());
  }
}

// YAML is UTF-8. Names in another encoding would not be those of the robot, and no report could say them.
void check_encoding(const std::string& text, const std::string& path) {
  const size_t at = find_strange_byte(text);
  if (at == std::string::npos) return;
  const size_t begin = at == 0 ? std::string::npos : text.rfind('\n', at - 1);
  const int line = 1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<long>(at), '\n'));
  const int column = static_cast<int>(begin == std::string::npos ? at + 1 : at - begin);
  refuse_input({path, "", line, column}, describe_strange_byte(text, at));
}

Scenario parse_unchecked(const std::string& text, const std::string& path, Diagnostics* diagnostics) {
  check_encoding(text, path);
  const YAML::Node root = parse_yaml(text, path);
  Scenario scenario;
  scenario.path = path;
  scenario.text = text;
  YamlContext context{path, diagnostics, &scenario.marks};
  try {
    YamlMap map(root, "", &context);
    read_all(map, &scenario);
    check_look_rates(scenario, diagnostics);
  } catch (const YAML::Exception& error) {
    diagnostics->add_error({path, "", error.mark.is_null() ? 0 : error.mark.line + 1}, "not usable YAML: " + error.msg);
  }
  resolve_paths(&scenario);
  return scenario;
}

}  // namespace

Scenario::Scenario() = default;
Scenario::Scenario(const Scenario&) = default;
Scenario::Scenario(Scenario&&) noexcept = default;
Scenario& Scenario::operator=(const Scenario&) = default;
Scenario& Scenario::operator=(Scenario&&) noexcept = default;
Scenario::~Scenario() = default;

Diagnostic Scenario::make_diagnostic(const std::string& key_path, const std::string& message) const {
  Diagnostic d;
  d.file = path;
  d.field = key_path;
  d.message = message;
  for (std::string key = key_path; !key.empty();) {
    const auto it = marks.find(key);
    if (it != marks.end()) {
      d.line = it->second.first;
      d.column = it->second.second;
      break;
    }
    const size_t cut = key.find_last_of(".[");
    key = cut == std::string::npos ? "" : key.substr(0, cut);
  }
  return d;
}

Scenario load_scenario(const std::string& path) {
  std::error_code error;
  Diagnostics diagnostics;
  Scenario scenario = parse_unchecked(read_input(path), make_absolute(path, fs::current_path(error)), &diagnostics);
  check_file(scenario, "robot", scenario.robot, &diagnostics);
  check_file(scenario, "controller.motion", scenario.controller.motion, &diagnostics);
  check_file(scenario, "world", scenario.world, &diagnostics);
  for (const RobotPlacement& robot : scenario.robots)
    check_file(scenario, "robots." + robot.name + ".scenario", robot.scenario, &diagnostics);
  for (const ObstacleSpec& obstacle : scenario.obstacles) {
    check_file(scenario, "obstacles." + obstacle.name + ".file", obstacle.file, &diagnostics);
  }
  if (diagnostics.has_errors()) throw InputError(diagnostics);
  return scenario;
}

std::string set_initial_joints(const std::string& text, const std::map<std::string, double>& joints) {
  YAML::Node root = YAML::Load(text);
  YAML::Node values(YAML::NodeType::Map);
  for (const auto& [name, position] : joints) values[name] = format_exact(position);
  values.SetStyle(YAML::EmitterStyle::Flow);
  YAML::Emitter flow;
  flow << values;
  // Usual text gets one line more, so that its comments and line numbers stay; other YAML is written anew.
  if (!root["initial"] && root.Style() == YAML::EmitterStyle::Block && text.find("\n...") == std::string::npos) {
    std::string longer =
        text + (text.empty() || text.back() == '\n' ? "" : "\n") + "initial: {joints: " + flow.c_str() + "}\n";
    try {
      if (YAML::Load(longer)["initial"]["joints"].size() == joints.size()) return longer;
    } catch (const YAML::Exception&) {  // say, a text that ends within a block: written anew below
    }
  }
  root["initial"]["joints"] = values;
  YAML::Emitter all;
  all << root;
  return std::string(all.c_str()) + "\n";
}

Scenario parse_scenario(const std::string& text, const std::string& path) {
  Diagnostics diagnostics;
  Scenario scenario = parse_unchecked(text, path, &diagnostics);
  if (diagnostics.has_errors()) throw InputError(diagnostics);
  return scenario;
}

}  // namespace hrp
