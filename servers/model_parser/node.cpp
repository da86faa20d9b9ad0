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

}  // namespace

ModelParserNode::ModelParserNode(const NodeContext& context, const std::string& scenario_path)
    : NodeBase(context),
      description_publisher_(bus(), topics::kRobotDescription),
      refused_publisher_(bus(), topics::kModelRefused) {
  load(scenario_path);
}

void ModelParserNode::load(const std::string& scenario_path) {
  try {
    const RobotDescription robot = load_robot(load_scenario(scenario_path));
    msg::RobotDescription message;
    to_message(robot, &message);
    description_publisher_.publish(message);
    std::string warnings;
    for (const std::string& warning : robot.warnings) warnings += (warnings.empty() ? "" : "\n") + warning;
    if (!warnings.empty()) say(warnings);
    set_phase(msg::SERVER_READY);
  } catch (const InputError& error) {
    refused_publisher_.publish(make_refusal(error));
    fail(std::string("model refused\n") + error.what());
  }
}

}  // namespace hrp
