// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/link_sensor_keys.h"

#include "common/robot/yaml_map.h"

namespace hrp {
namespace {

std::vector<DeclaredJoint> read_joints(const std::string& path, const YAML::Node& node, const std::string& field) {
  std::vector<DeclaredJoint> list;
  if (!node) return list;
  const auto fail = [&](const YAML::Node& at) {
    refuse_input(make_place(path, at, field), "expected a list of joints, such as [shoulder, elbow]");
  };
  if (!node.IsSequence()) fail(node);
  for (const YAML::Node& item : node) {
    if (!item.IsScalar()) fail(item);
    list.push_back({item.as<std::string>(), item.Mark().line + 1, item.Mark().column + 1});
  }
  return list;
}

}  // namespace

LinkSensorKeys parse_link_sensor_keys(const std::string& text, const std::string& path) {
  LinkSensorKeys keys;
  const YAML::Node sensors = YAML::Load(text)["sensors"];  // was read before: it is YAML
  if (!sensors || !sensors.IsMap()) return keys;
  keys.joint_torque = read_joints(path, sensors["joint_torque"], "sensors.joint_torque");
  keys.link_encoder = read_joints(path, sensors["link_encoder"], "sensors.link_encoder");
  return keys;
}

}  // namespace hrp
