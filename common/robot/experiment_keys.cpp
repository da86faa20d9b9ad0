// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/experiment_keys.h"

#include <filesystem>

#include <yaml-cpp/yaml.h>

#include "common/base/diagnostics.h"
#include "common/robot/yaml_map.h"

namespace hrp {
namespace {

namespace fs = std::filesystem;

// Squares of what a rollout misses, in units of the noise, must stay finite.
constexpr double kLeastNoise = 1e-15;

std::vector<std::string> read_names(const std::string& path, const YAML::Node& node, const std::string& field) {
  std::vector<std::string> names;
  if (!node) return names;
  if (node.IsScalar()) return {node.as<std::string>()};
  if (!node.IsSequence()) refuse_input(make_place(path, node, field), "expected a list of names");
  for (const YAML::Node& item : node) {
    if (!item.IsScalar()) refuse_input(make_place(path, item, field), "expected a name");
    names.push_back(item.as<std::string>());
  }
  return names;
}

void read_load(YamlMap& map, LoadSpec* load) {
  map.require("link", "what carries the load");
  map.require("mass", "its mass [kg]");
  map.require("com", "its centre [x, y, z] in the link's frame [m]");
  map.text("link", &load->link);
  load->mass = 1.0;  // so that only a mass that is stated is complained of
  map.number("mass", &load->mass, Bound::kAny, "kg");
  if (!(load->mass > 0.0)) map.error("mass", "expected more than 0 kg");
  map.vector3("com", &load->p_LC, Bound::kAny, "m");
}

void read_push(YamlMap& map, HandPush* push) {
  push->known = map.has("force");
  if (push->known) map.require("link", "what the force pulls at");
  map.text("link", &push->link);
  map.vector3("force", &push->force_W, Bound::kAny, "N");
  map.vector3("xyz", &push->p_LQ, Bound::kAny, "m");
  if (!push->known && !(map.has("start") && map.has("duration")))
    map.error("", "an unknown force needs 'start' and 'duration'");
  double duration = push->end;
  map.number("start", &push->start, Bound::kAny, "s after the first sample");
  map.number("duration", &duration, Bound::kAny, "s");
  push->end = push->start + duration;
  if (!(push->end > push->start)) map.error("duration", "expected more than 0 s");
}

void read_by_hand(const std::string& path, const YAML::Node& node, const std::string& field, RecordingSpec* recording) {
  Diagnostics diagnostics;
  YamlContext context{path, &diagnostics, nullptr};
  YamlMap map(node, field, &context);
  map.list("loads", [&](size_t, YamlMap& own) { read_load(own, &recording->loads.emplace_back()); });
  map.list("pushes", [&](size_t, YamlMap& own) { read_push(own, &recording->pushes.emplace_back()); });
  if (diagnostics.has_errors()) throw InputError(diagnostics);
}

RecordingSpec read_recording(const std::string& path, const YAML::Node& node, const std::string& field) {
  if (!node.IsMap()) refuse_input(make_place(path, node, field), "expected {file: ..., role: train or validate}");
  RecordingSpec recording;
  for (const auto& item : node) {
    const std::string key = item.first.as<std::string>();
    if (key != "file" && key != "role" && key != "feet_attached" && key != "unknown_force" && key != "loads" &&
        key != "pushes" && key != "columns" && key != "notes") {
      refuse_input(make_place(path, item.first, field + "." + key),
                   "unknown key; expected file, role, columns, loads, pushes, feet_attached or unknown_force");
    }
  }
  if (!node["file"] || !node["file"].IsScalar())
    refuse_input(make_place(path, node, field + ".file"), "is missing: the recording's file");
  recording.name = node["file"].as<std::string>();
  recording.line = node.Mark().line + 1;
  const fs::path file(recording.name);
  recording.file = (file.is_absolute() ? file : fs::path(path).parent_path() / file).lexically_normal().string();
  // A folder is a ROS bag.
  std::error_code error;  // a name that is too long for a file, links in a circle
  if (!fs::is_regular_file(recording.file, error) && !fs::is_directory(recording.file, error)) {
    refuse_input(make_place(path, node["file"], field + ".file"),
                 "there is no file or bag folder '" + recording.file + "'");
  }
  const std::string role = node["role"] && node["role"].IsScalar() ? node["role"].as<std::string>() : "train";
  if (role != "train" && role != "validate") {
    refuse_input(make_place(path, node["role"], field + ".role"), "is '" + role + "', expected train or validate");
  }
  recording.train = role == "train";
  recording.feet_attached = read_names(path, node["feet_attached"], field + ".feet_attached");
  recording.unknown_force = read_names(path, node["unknown_force"], field + ".unknown_force");
  read_by_hand(path, node, field, &recording);
  return recording;
}

void read_noise(const std::string& path, const YAML::Node& node, ExperimentKeys* keys) {
  if (!node) return;
  if (!node.IsMap()) refuse_input(make_place(path, node, "noise"), "expected standard deviations by quantity");
  for (const auto& item : node) {
    const std::string key = item.first.as<std::string>();
    double value = 0.0;
    if (key != "position" && key != "velocity" && key != "effort" && key.rfind('/', 0) != 0)
      refuse_input(make_place(path, item.first, "noise." + key),
                   "expected position, velocity, effort, or a sensor or column such as /imu/waist");
    if (!item.second.IsScalar() || !YAML::convert<double>::decode(item.second, value) ||
        !(value >= kLeastNoise && value <= kLargestNumber)) {
      refuse_input(make_place(path, item.second, "noise." + key), "expected a standard deviation from 1e-15 to 1e12");
    }
    keys->noise[key] = value;
  }
}

// The rate of files without stamps (column_map.h); others say it for people.
void check_sample_rate(const std::string& path, const YAML::Node& node) {
  double value = 0.0;
  if (!node ||
      (node.IsScalar() && YAML::convert<double>::decode(node, value) && value > 0.0 && value <= kLargestNumber))
    return;
  refuse_input(make_place(path, node, "sample_rate"), "expected a rate of more than 0 Hz, at most 1e12 Hz");
}

}  // namespace

ExperimentKeys parse_experiment_keys(const std::string& text, const std::string& path) {
  ExperimentKeys keys;
  try {
    const YAML::Node root = YAML::Load(text);
    const YAML::Node list = root["recordings"];
    if (!list || !list.IsSequence() || list.size() == 0) {
      refuse_input(make_place(path, list ? list : root, "recordings"),
                   "expected a list of {file: ..., role: train or validate}");
    }
    for (size_t i = 0; i < list.size(); ++i) {
      keys.recordings.push_back(read_recording(path, list[i], "recordings[" + std::to_string(i) + "]"));
    }
    read_noise(path, root["noise"], &keys);
    check_sample_rate(path, root["sample_rate"]);
    const YAML::Node sensors = root["sensors"];
    if (sensors && sensors.IsMap() && sensors["wrench"] && sensors["wrench"].IsMap()) {
      for (const auto& item : sensors["wrench"]) {
        const YAML::Node frame = item.second.IsMap() ? item.second["frame"] : YAML::Node();
        if (frame && frame.IsScalar()) keys.wrench_frame[item.first.as<std::string>()] = frame.as<std::string>();
      }
    }
  } catch (const YAML::Exception& error) {
    refuse_input(make_place(path, error.mark), "not usable YAML: " + error.msg);
  }
  return keys;
}

}  // namespace hrp
