// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/experiment_keys.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <yaml-cpp/yaml.h>

#include "common/base/diagnostics.h"

namespace hrp {
namespace {

namespace fs = std::filesystem;

// Squares of what a rollout misses, in units of the noise, must stay finite.
constexpr double kLeastNoise = 1e-15, kMostNoise = 1e12;

[[noreturn]] void fail(const std::string& path, const YAML::Node& node, const std::string& field, const std::string& text) {
  Diagnostic d;
  d.file = path, d.field = field, d.message = text;
  if (node.IsDefined() && !node.Mark().is_null()) d.line = node.Mark().line + 1, d.column = node.Mark().column + 1;
  throw InputError(d);
}

std::vector<std::string> read_names(const std::string& path, const YAML::Node& node, const std::string& field) {
  std::vector<std::string> names;
  if (!node) return names;
  if (node.IsScalar()) return {node.as<std::string>()};
  if (!node.IsSequence()) fail(path, node, field, "expected a list of names");
  for (const YAML::Node& item : node) {
    if (!item.IsScalar()) fail(path, item, field, "expected a name");
    names.push_back(item.as<std::string>());
  }
  return names;
}

double read_number(const std::string& path, const YAML::Node& node, const std::string& field, const char* expected) {
  double value = 0.0;
  if (!node || !node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value)) fail(path, node, field, std::string("expected ") + expected);
  return value;
}

Vector3d read_vector(const std::string& path, const YAML::Node& parent, const char* key, const std::string& field, const char* expected) {
  const YAML::Node node = parent[key];
  const std::string own = field + "." + key;
  if (!node || !node.IsSequence() || node.size() != 3) fail(path, node ? node : parent, own, std::string("expected ") + expected);
  Vector3d v;
  for (size_t i = 0; i < 3; ++i) v[static_cast<long>(i)] = read_number(path, node[i], own, expected);
  return v;
}

// One entry of `loads` or `pushes`: nothing but these keys.
void check_entry(const std::string& path, const YAML::Node& node, const std::string& field, const std::vector<std::string>& keys) {
  std::string list;
  for (const std::string& key : keys) list += (list.empty() ? "" : ", ") + key;
  if (!node.IsMap()) fail(path, node, field, "expected a map with " + list);
  for (const auto& item : node) {
    const std::string key = item.first.as<std::string>();
    if (std::find(keys.begin(), keys.end(), key) == keys.end()) fail(path, item.first, field + "." + key, "unknown key; expected " + list);
  }
}

std::vector<LoadSpec> read_loads(const std::string& path, const YAML::Node& list, const std::string& field) {
  std::vector<LoadSpec> loads;
  if (!list) return loads;
  if (!list.IsSequence()) fail(path, list, field, "expected a list of {link: ..., mass: kg, com: [x, y, z]}");
  for (size_t i = 0; i < list.size(); ++i) {
    const std::string own = field + "[" + std::to_string(i) + "]";
    check_entry(path, list[i], own, {"link", "mass", "com"});
    if (!list[i]["link"] || !list[i]["link"].IsScalar()) fail(path, list[i], own + ".link", "is missing: what carries the load");
    LoadSpec load;
    load.link = list[i]["link"].as<std::string>();
    load.mass = read_number(path, list[i]["mass"], own + ".mass", "its mass in kg");
    if (!(load.mass > 0.0)) fail(path, list[i]["mass"], own + ".mass", "expected more than 0 kg");
    load.p_LC = read_vector(path, list[i], "com", own, "its centre [x, y, z] in the link's frame, m");
    loads.push_back(load);
  }
  return loads;
}

HandPush read_push(const std::string& path, const YAML::Node& node, const std::string& field) {
  check_entry(path, node, field, {"link", "force", "xyz", "start", "duration"});
  HandPush push;
  if (node["link"]) push.link = node["link"].IsScalar() ? node["link"].as<std::string>() : "";
  push.known = static_cast<bool>(node["force"]);
  if (push.known && push.link.empty()) fail(path, node, field + ".link", "is missing: what the force pulls at");
  if (push.known) push.force_W = read_vector(path, node, "force", field, "a force [x, y, z] in world axes, N");
  if (node["xyz"]) push.p_LQ = read_vector(path, node, "xyz", field, "where it pulls, [x, y, z] in the link's frame, m");
  const char* const seconds = "seconds, 'start' after the first sample";
  if (!push.known && !(node["start"] && node["duration"])) fail(path, node, field, "an unknown force needs 'start' and 'duration'");
  if (node["start"]) push.start = read_number(path, node["start"], field + ".start", seconds);
  if (node["duration"]) push.end = push.start + read_number(path, node["duration"], field + ".duration", seconds);
  if (!(push.end > push.start)) fail(path, node["duration"], field + ".duration", "expected more than 0 s");
  return push;
}

RecordingSpec read_recording(const std::string& path, const YAML::Node& node, const std::string& field) {
  if (!node.IsMap()) fail(path, node, field, "expected {file: ..., role: train or validate}");
  RecordingSpec recording;
  for (const auto& item : node) {
    const std::string key = item.first.as<std::string>();
    if (key != "file" && key != "role" && key != "feet_attached" && key != "unknown_force" && key != "loads" &&
        key != "pushes" && key != "notes") {
      fail(path, item.first, field + "." + key, "unknown key; expected file, role, loads, pushes, feet_attached or unknown_force");
    }
  }
  if (!node["file"] || !node["file"].IsScalar()) fail(path, node, field + ".file", "is missing: the recording's file");
  recording.name = node["file"].as<std::string>();
  recording.line = node.Mark().line + 1;
  const fs::path file(recording.name);
  recording.file = (file.is_absolute() ? file : fs::path(path).parent_path() / file).lexically_normal().string();
  // A folder is a ROS bag.
  std::error_code error;  // a name that is too long for a file, links in a circle
  if (!fs::is_regular_file(recording.file, error) && !fs::is_directory(recording.file, error)) {
    fail(path, node["file"], field + ".file", "there is no file or bag folder '" + recording.file + "'");
  }
  const std::string role = node["role"] && node["role"].IsScalar() ? node["role"].as<std::string>() : "train";
  if (role != "train" && role != "validate") {
    fail(path, node["role"], field + ".role", "is '" + role + "', expected train or validate");
  }
  recording.train = role == "train";
  recording.feet_attached = read_names(path, node["feet_attached"], field + ".feet_attached");
  recording.unknown_force = read_names(path, node["unknown_force"], field + ".unknown_force");
  recording.loads = read_loads(path, node["loads"], field + ".loads");
  const YAML::Node pushes = node["pushes"];
  if (pushes && !pushes.IsSequence()) fail(path, pushes, field + ".pushes", "expected a list of {link: ..., force: [x, y, z], xyz: [x, y, z], start: s, duration: s}");
  for (size_t i = 0; pushes && i < pushes.size(); ++i)
    recording.pushes.push_back(read_push(path, pushes[i], field + ".pushes[" + std::to_string(i) + "]"));
  return recording;
}

void read_noise(const std::string& path, const YAML::Node& node, ExperimentKeys* keys) {
  if (!node) return;
  if (!node.IsMap()) fail(path, node, "noise", "expected standard deviations by quantity");
  for (const auto& item : node) {
    const std::string key = item.first.as<std::string>();
    double value = 0.0;
    if (!item.second.IsScalar() || !YAML::convert<double>::decode(item.second, value) || !(value >= kLeastNoise && value <= kMostNoise)) {
      fail(path, item.second, "noise." + key, "expected a standard deviation from 1e-15 to 1e12");
    }
    keys->noise[key] = value;
  }
}

}  // namespace

ExperimentKeys parse_experiment_keys(const std::string& text, const std::string& path) {
  ExperimentKeys keys;
  try {
    const YAML::Node root = YAML::Load(text);
    const YAML::Node list = root["recordings"];
    if (!list || !list.IsSequence() || list.size() == 0) {
      fail(path, list ? list : root, "recordings", "expected a list of {file: ..., role: train or validate}");
    }
    for (size_t i = 0; i < list.size(); ++i) {
      keys.recordings.push_back(read_recording(path, list[i], "recordings[" + std::to_string(i) + "]"));
    }
    read_noise(path, root["noise"], &keys);
    const YAML::Node sensors = root["sensors"];
    if (sensors && sensors.IsMap() && sensors["wrench"] && sensors["wrench"].IsMap()) {
      for (const auto& item : sensors["wrench"]) {
        const YAML::Node frame = item.second.IsMap() ? item.second["frame"] : YAML::Node();
        if (frame && frame.IsScalar()) keys.wrench_frame[item.first.as<std::string>()] = frame.as<std::string>();
      }
    }
  } catch (const YAML::Exception& error) {
    Diagnostic d;
    d.file = path, d.message = "not usable YAML: " + error.msg;
    if (!error.mark.is_null()) d.line = error.mark.line + 1, d.column = error.mark.column + 1;
    throw InputError(d);
  }
  return keys;
}

}  // namespace hrp
