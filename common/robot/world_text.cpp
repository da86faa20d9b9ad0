// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/world_text.h"

#include <yaml-cpp/yaml.h>

#include "common/base/exact_number.h"
#include "common/spatial/rpy.h"

namespace hrp {
namespace {

YAML::Node make_list(const Vector3d& v) {
  YAML::Node list(YAML::NodeType::Sequence);
  for (int i = 0; i < 3; ++i) list.push_back(format_exact(v[i]));
  return list;
}

YAML::Node make_node(const ObstacleSpec& obstacle) {
  YAML::Node node(YAML::NodeType::Map);
  node["shape"] = obstacle.shape;
  if (obstacle.shape == "box") node["size"] = make_list(obstacle.size);
  if (obstacle.shape == "sphere" || obstacle.shape == "cylinder") node["radius"] = format_exact(obstacle.size.x());
  if (obstacle.shape == "cylinder") node["length"] = format_exact(obstacle.size.y());
  if (obstacle.shape == "mesh") {
    node["file"] = obstacle.file;
    node["scale"] = make_list(obstacle.scale);
  }
  node["position"] = make_list(obstacle.X_WG.p);
  node["rpy"] = make_list(calc_rpy(obstacle.X_WG.R));
  node["friction"] = format_exact(obstacle.friction);
  return node;
}

YAML::Node make_node(const GroundSpec& ground) {
  YAML::Node node(YAML::NodeType::Map);
  node["type"] = ground.present ? "plane" : "none";
  if (!ground.present) return node;
  node["height"] = format_exact(ground.height);
  node["roll"] = format_exact(ground.roll);
  node["pitch"] = format_exact(ground.pitch);
  node["friction"] = format_exact(ground.friction);
  return node;
}

std::string print_flow(const YAML::Node& node) {
  YAML::Emitter out;
  out.SetMapFormat(YAML::Flow);
  out.SetSeqFormat(YAML::Flow);
  out << node;
  return out.c_str();
}

// The line of `world` becomes a remark, and sections are added at the end, so that all other lines keep their numbers.
// Empty when the text cannot be treated so.
std::string add_lines(const std::string& text, const YAML::Node& root, const YAML::Node& added) {
  const size_t line = text.rfind("world:", 0) == 0 ? 0 : text.find("\nworld:") + 1;
  if (root.Style() != YAML::EmitterStyle::Block || text.find("\n...") != std::string::npos ||
      (line == 0 && text[0] != 'w'))
    return "";
  std::string longer = text.substr(0, line) + "# " + text.substr(line);
  if (longer.back() != '\n') longer += "\n";
  for (const auto& section : added) {
    if (root[section.first.Scalar()]) return "";
    longer += section.first.Scalar() + ": " + print_flow(section.second) + "\n";
  }
  try {
    const YAML::Node read = YAML::Load(longer);
    if (!read["world"] && read.size() == root.size() - 1 + added.size()) return longer;
  } catch (const YAML::Exception&) {  // say, a text that ends within a block
  }
  return "";
}

}  // namespace

std::string add_world(const std::string& text, const WorldSpec& world) {
  YAML::Node root = YAML::Load(text);
  YAML::Node added(YAML::NodeType::Map);
  if (!root["ground"]) added["ground"] = make_node(world.ground);
  YAML::Node obstacles(YAML::NodeType::Map);
  for (const ObstacleSpec& obstacle : world.obstacles) obstacles[obstacle.name] = make_node(obstacle);
  if (obstacles.size() > 0) added["obstacles"] = obstacles;
  std::string longer = add_lines(text, root, added);
  if (!longer.empty()) return longer;
  // Other YAML is written anew.
  root.remove("world");
  if (!root["ground"]) root["ground"] = added["ground"];
  for (const auto& entry : obstacles) root["obstacles"][entry.first] = entry.second;
  YAML::Emitter all;
  all << root;
  return std::string(all.c_str()) + "\n";
}

Scenario adopt_world(const Scenario& scenario, const std::string& merged) {
  Scenario result = scenario;
  if (scenario.world.empty()) return result;
  const Scenario read = parse_scenario(merged, scenario.path);
  result.obstacles = read.obstacles;
  result.ground = read.ground;
  return result;
}

}  // namespace hrp
