// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/node.h"

#include "common/messages/convert_robot.h"
#include "common/messages/topics.h"
#include "servers/model_parser/robot_loader.h"

namespace hrp {
namespace {

msg::ModelRefused make_refusal(const InputError& error) {
  msg::ModelRefused refused;
  for (const Diagnostic& diagnostic : error.diagnostics()) {
    if (diagnostic.severity != Diagnostic::Severity::kError) continue;
    msg::ModelRefusal refusal;
    refusal.file(diagnostic.file);
    refusal.line(static_cast<uint32_t>(diagnostic.line));
    refusal.element(diagnostic.field);
    refusal.reason(diagnostic.message);
    refused.refusals().push_back(refusal);
  }
  return refused;
}

// One line each, except for missing meshes of links that are no feet (kWithoutMesh): robots come with dozens of them.
std::string join_warnings(const std::vector<std::string>& warnings, bool verbose) {
  std::string text;
  int meshes = 0;
  for (const std::string& warning : warnings) {
    const bool mesh = warning.find(kWithoutMesh) != std::string::npos;
    meshes += mesh;
    if (!mesh || verbose) text += (text.empty() ? "" : "\n") + warning;
  }
  if (meshes == 0 || verbose) return text;
  return text + (text.empty() ? "" : "\n") + std::to_string(meshes) +
         (meshes == 1 ? " collision mesh" : " collision meshes") +
         " not found, simulated without; hrp-simulate --verbose lists them";
}

}  // namespace

ModelParserNode::ModelParserNode(const NodeContext& context, const std::string& scenario_path, bool verbose)
    : NodeBase(context),
      description_publisher_(bus(), topics::kRobotDescription),
      refused_publisher_(bus(), topics::kModelRefused) {
  load(scenario_path, verbose);
}

void ModelParserNode::load(const std::string& scenario_path, bool verbose) {
  try {
    const RobotDescription robot = load_robot(load_scenario(scenario_path));
    msg::RobotDescription message;
    to_message(robot, &message);
    for (const OtherRobot& other : robot.robots) publish_other(other);
    description_publisher_.publish(message);
    const std::string warnings = join_warnings(robot.warnings, verbose);
    if (!warnings.empty()) say(warnings);
    set_phase(msg::SERVER_READY);
  } catch (const InputError& error) {
    refused_publisher_.publish(make_refusal(error));
    fail(std::string("model refused\n") + error.what());
  }
}

// For the controller of that robot.
void ModelParserNode::publish_other(const OtherRobot& other) {
  msg::RobotDescription message;
  to_message(other.description, &message);
  other_publishers_.emplace_back(bus(), topics::of_robot(topics::kRobotDescription, other.name));
  other_publishers_.back().publish(message);
}

}  // namespace hrp
