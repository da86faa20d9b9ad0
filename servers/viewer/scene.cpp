// SPDX-License-Identifier: BSD-3-Clause
#include "servers/viewer/scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <nlohmann/json.hpp>

#include "common/base/diagnostics.h"
#include "common/base/file_ending.h"
#include "common/messages/cdr.h"
#include "common/messages/convert_robot.h"
#include "common/robot/experiment_keys.h"
#include "common/robot/scenario.h"
#include "servers/viewer/dump_json.h"

namespace hrp {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// Larger meshes are none.
constexpr uintmax_t kLargestMesh = 64 << 20;

Json make_number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

// The moving link that a URDF link belongs to: forces carry its name.
std::string find_moving_link(const msg::RobotDescription& description, const std::string& name) {
  for (const auto& frame : description.frames()) {
    const size_t link = static_cast<size_t>(frame.link());
    if (frame.name() == name && link < description.links().size()) return description.links()[link].name();
  }
  return name;
}

Json make_joints(const msg::RobotDescription& description) {
  Json joints = Json::array();
  for (const auto& joint : description.joints()) {
    joints.push_back({{"name", joint.name()},
                      {"unit", joint.kind() == msg::JOINT_PRISMATIC ? "m" : "rad"},
                      {"effortUnit", joint.kind() == msg::JOINT_PRISMATIC ? "N" : "N m"},
                      {"lower", make_number(joint.lower())},
                      {"upper", make_number(joint.upper())}});
  }
  return joints;
}

Mesh find_triangles(const msg::RobotDescription& description, const std::string& obstacle) {
  for (const msg::SurfaceDescription& surface : description.surfaces()) {
    if (surface.obstacle() != obstacle) continue;
    try {
      return make_triangles(from_message(surface));
    } catch (const InputError&) {
      return {};  // anybody can send a description: what makes no sense is not drawn
    }
  }
  return {};
}

// Lists of three numbers and three indices each, one after the other.
void add_triangles(const Mesh& mesh, Json* obstacle) {
  std::vector<double> vertices;
  std::vector<int> triangles;
  for (const Vector3d& v : mesh.vertices) vertices.insert(vertices.end(), v.data(), v.data() + 3);
  for (const auto& triangle : mesh.triangles) triangles.insert(triangles.end(), triangle.begin(), triangle.end());
  (*obstacle)["vertices"] = vertices;
  (*obstacle)["triangles"] = triangles;
}

Json make_obstacles(const msg::RobotDescription& description, const Scenario& scenario) {
  Json obstacles = Json::array();
  for (const ObstacleSpec& obstacle : scenario.obstacles) {
    const Vector3d& p = obstacle.X_WG.p;
    const Eigen::Quaterniond q(obstacle.X_WG.R);
    obstacles.push_back({{"name", obstacle.name},
                         {"shape", obstacle.shape},
                         {"size", {obstacle.size.x(), obstacle.size.y(), obstacle.size.z()}},
                         {"position", {p.x(), p.y(), p.z()}},
                         {"quaternion", {q.w(), q.x(), q.y(), q.z()}}});
    if (obstacle.is_surface()) add_triangles(find_triangles(description, obstacle.name), &obstacles.back());
  }
  return obstacles;
}

// A robot without a scenario that we understand still moves: then what is empty.
Scenario read_scenario(const msg::RobotDescription& description) {
  try {
    return parse_scenario(description.scenario(), description.scenario_path());
  } catch (const std::exception&) {
    return {};
  }
}

// Names as contact forces have them: `prefix` in front of those of another robot.
Json make_feet(const msg::RobotDescription& description, const Scenario& scenario, const std::string& prefix) {
  Json feet = Json::array();
  for (const std::string& foot : scenario.feet)
    feet.push_back({{"name", prefix + foot}, {"link", prefix + find_moving_link(description, foot)}});
  return feet;
}

// Where the points of a lidar lie: in its mount, which is fixed to a link (none: to the world).
Json make_lidars(const Scenario& scenario) {
  Json lidars = Json::array();
  for (const LidarSpec& lidar : scenario.sensors.lidars) {
    const Vector3d& p = lidar.X_LC.p;
    const Eigen::Quaterniond q(lidar.X_LC.R);
    lidars.push_back({{"name", lidar.name},
                      {"link", lidar.link},
                      {"position", {p.x(), p.y(), p.z()}},
                      {"quaternion", {q.w(), q.x(), q.y(), q.z()}}});
  }
  return lidars;
}

void add_scenario(const msg::RobotDescription& description, Json* json, Scene* scene) {
  const Scenario scenario = read_scenario(description);
  ExperimentKeys keys;
  try {
    keys = parse_experiment_keys(description.scenario(), description.scenario_path());
  } catch (const std::exception&) {  // of no experiment
  }
  Json wrenches = Json::array();
  for (const WrenchSpec& wrench : scenario.sensors.wrenches) {
    const auto frame = keys.wrench_frame.find(wrench.name);
    wrenches.push_back({{"name", wrench.name},
                        {"link", wrench.link},
                        {"frame", frame == keys.wrench_frame.end() ? "link" : frame->second}});
  }
  (*json)["feet"] = make_feet(description, scenario, "");
  (*json)["wrenches"] = wrenches;
  (*json)["lidars"] = make_lidars(scenario);
  (*json)["obstacles"] = make_obstacles(description, scenario);
  (*json)["objects"] = Json::array();
  for (const ObjectSpec& object : scenario.objects) {
    (*json)["objects"].push_back({{"name", object.name},
                                  {"shape", object.shape},
                                  {"size", {object.size.x(), object.size.y(), object.size.z()}}});
  }
  (*json)["ground"] = {{"present", scenario.ground.present},
                       {"height", scenario.ground.height},
                       {"roll", scenario.ground.roll},
                       {"pitch", scenario.ground.pitch},
                       {"friction", scenario.ground.friction}};
  (*json)["timeStep"] = scenario.time_step;
  scene->ground_height = scenario.ground.present ? scenario.ground.height : std::numeric_limits<double>::quiet_NaN();
}

bool is_mesh_name(const std::string& name) {
  const std::string ending = find_ending(name);
  return ending == ".stl" || ending == ".dae" || ending == ".obj";
}

// `file` when it is a file inside of `root`, symbolic links followed.
std::optional<fs::path> find_inside(const fs::path& root, const fs::path& file) {
  std::error_code error;
  const fs::path real_root = fs::canonical(root, error);
  if (error) return std::nullopt;
  const fs::path real_file = fs::canonical(root / file, error);
  if (error || !fs::is_regular_file(real_file, error)) return std::nullopt;
  const auto [end, rest] = std::mismatch(real_root.begin(), real_root.end(), real_file.begin(), real_file.end());
  return end == real_root.end() ? std::optional<fs::path>(real_file) : std::nullopt;
}

std::optional<fs::path> find_mesh_file(const fs::path& folder, std::string name) {
  const std::string package = "package://";
  if (name.rfind("file://", 0) == 0) name = fs::path(name.substr(7)).lexically_relative(folder).string();
  if (name.rfind(package, 0) != 0) return find_inside(folder, name);
  const std::string path = name.substr(package.size());
  const size_t slash = path.find('/');
  if (slash == std::string::npos) return std::nullopt;
  const std::string rest = path.substr(slash + 1);
  // The package is a folder above the URDF, or beside one of those; renamed packages have the rest at the URDF.
  fs::path above = folder;
  for (int i = 0; i < 4; ++i, above = above.parent_path()) {
    if (auto found = find_inside(above / path.substr(0, slash), rest)) return found;
  }
  if (auto found = find_inside(folder, rest)) return found;
  return find_inside(folder.parent_path(), rest);
}

// Names of meshes in the URDF whose files are there, so that pages ask for no others.
Json find_meshes(const Scene& scene) {
  Json found = Json::array();
  const std::string mark = "filename=\"";
  for (size_t at = scene.urdf.find(mark); at != std::string::npos; at = scene.urdf.find(mark, at)) {
    at += mark.size();
    const std::string name = scene.urdf.substr(at, scene.urdf.find('"', at) - at);
    if (is_mesh_name(name) && find_mesh_file(fs::path(scene.urdf_path).parent_path(), name)) found.push_back(name);
  }
  return found;
}

// What a page needs to draw a robot.
Json make_model(const msg::RobotDescription& description, Scene* scene) {
  for (const auto& joint : description.joints()) scene->joints.push_back(joint.name());
  scene->urdf_path = description.urdf_path();
  scene->urdf = description.urdf();
  return {{"name", description.name()},
          {"urdf", description.urdf()},
          {"floating", static_cast<bool>(description.floating_base())},
          {"joints", make_joints(description)},
          {"meshes", find_meshes(*scene)}};
}

void add_robot(const msg::OtherRobotDescription& other, Json* json, Scene* scene) {
  msg::RobotDescription description;
  try {
    decode(Bytes{other.description().data(), other.description().size()}, &description);
  } catch (const DecodeError&) {
    return;  // anybody can send a description: what makes no sense is not drawn
  }
  Scene own;
  own.name = other.name();
  Json model = make_model(description, &own);
  model["name"] = other.name();
  model["feet"] = make_feet(description, read_scenario(description), other.name() + "/");
  (*json)["robots"].push_back(std::move(model));
  scene->robots.push_back(std::move(own));
}

}  // namespace

const Scene* find_robot_scene(const Scene& scene, const std::string& name) {
  if (name.empty()) return &scene;
  const auto found =
      std::find_if(scene.robots.begin(), scene.robots.end(), [&](const Scene& robot) { return robot.name == name; });
  return found == scene.robots.end() ? nullptr : &*found;
}

Scene make_scene(const msg::RobotDescription& description) {
  Scene scene;
  Json json = make_model(description, &scene);
  json["warnings"] = description.warnings();
  json["scenario"] = fs::path(description.scenario_path()).filename().string();
  json["robots"] = Json::array();
  for (const msg::OtherRobotDescription& other : description.robots()) add_robot(other, &json, &scene);
  add_scenario(description, &json, &scene);
  scene.json = dump_json(json);
  return scene;
}

std::optional<WebFile> read_mesh(const Scene& scene, const std::string& name) {
  if (name.empty() || !is_mesh_name(name) || scene.urdf.find("\"" + name + "\"") == std::string::npos)
    return std::nullopt;
  const auto path = find_mesh_file(fs::path(scene.urdf_path).parent_path(), name);
  std::error_code error;
  if (!path || !is_mesh_name(path->string()) || fs::file_size(*path, error) > kLargestMesh) return std::nullopt;
  std::ifstream file(*path, std::ios::binary);
  std::ostringstream content;
  content << file.rdbuf();
  return WebFile{content.str(), "application/octet-stream"};
}

}  // namespace hrp
