// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/experiment_keys.h"

#include <filesystem>

#include <yaml-cpp/yaml.h>

#include "common/base/diagnostics.h"

namespace hrp {
namespace {

namespace fs = std::filesystem;

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

RecordingSpec read_recording(const std::string& path, const YAML::Node& node, const std::string& field) {
  if (!node.IsMap()) fail(path, node, field, "expected {file: ..., role: train or validate}");
  RecordingSpec recording;
  for (const auto& item : node) {
    const std::string key = item.first.as<std::string>();
    if (key != "file" && key != "role" && key != "feet_attached" && key != "unknown_force" && key != "notes") {
      fail(path, item.first, field + "." + key, "unknown key; expected file, role, feet_attached or unknown_force");
    }
  }
  if (!node["file"] || !node["file"].IsScalar()) fail(path, node, field + ".file", "is missing: the recording's file");
  recording.name = node["file"].as<std::string>();
  recording.line = node.Mark().line + 1;
  const fs::path file(recording.name);
  recording.file = (file.is_absolute() ? file : fs::path(path).parent_path() / file).lexically_normal().string();
  // A folder is a ROS bag.
  if (!fs::is_regular_file(recording.file) && !fs::is_directory(recording.file)) {
    fail(path, node["file"], field + ".file", "there is no file or bag folder '" + recording.file + "'");
  }
  const std::string role = node["role"] && node["role"].IsScalar() ? node["role"].as<std::string>() : "train";
  if (role != "train" && role != "validate") {
    fail(path, node["role"], field + ".role", "is '" + role + "', expected train or validate");
  }
  recording.train = role == "train";
  recording.feet_attached = read_names(path, node["feet_attached"], field + ".feet_attached");
  recording.unknown_force = read_names(path, node["unknown_force"], field + ".unknown_force");
  return recording;
}

void read_noise(const std::string& path, const YAML::Node& node, ExperimentKeys* keys) {
  if (!node) return;
  if (!node.IsMap()) fail(path, node, "noise", "expected standard deviations by quantity");
  for (const auto& item : node) {
    const std::string key = item.first.as<std::string>();
    double value = 0.0;
    if (!item.second.IsScalar() || !YAML::convert<double>::decode(item.second, value) || !(value > 0.0)) {
      fail(path, item.second, "noise." + key, "expected a positive standard deviation");
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
