// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cstdio>
#include <stdexcept>

#include "common/messages/reflection/sample.h"
#include "common/messages/ros_topics.h"
#include "servers/console/topic_tool/sample_text.h"
#include "servers/console/topic_tool/topic_tool.h"

namespace hrp {
namespace {

// The writer sees its reader before the reader may see the writer, and what a volatile reader has not matched it drops.
constexpr auto kDiscovery = std::chrono::milliseconds(300);
// For what was lost on the way to be sent again.
constexpr auto kDelivery = std::chrono::milliseconds(200);

// "joint_trajectory", "/joint_trajectory", "rt/joint_trajectory"; of a robot "partner/joint_trajectory", likewise.
TopicSpec find_command_topic(const std::string& name) {
  std::string plain = name.rfind("/", 0) == 0 ? name.substr(1) : name;
  if (const std::string ros = topics::find_ros_topic(plain); !ros.empty()) plain = ros.substr(1);
  const size_t slash = plain.find('/');
  const std::string robot = slash == std::string::npos ? "" : plain.substr(0, slash);
  for (const TopicSpec* topic : {&topics::kRosJointTrajectory, &topics::kRosPositionCommands}) {
    TopicSpec found = topics::of_robot(*topic, robot);
    if (topics::find_ros_topic(found.name) == "/" + plain) return found;
  }
  throw std::runtime_error("nothing can be sent on '" + name + "'; topics for commands: " +
                           topics::kRosJointTrajectory.name + ", " + topics::kRosPositionCommands.name);
}

void spin(const ToolContext& context, std::chrono::milliseconds time) {
  const auto end = std::chrono::steady_clock::now() + time;
  while (std::chrono::steady_clock::now() < end && !context.must_stop())
    context.bus->spin(std::chrono::milliseconds(10));
}

Bytes get_bytes(const std::vector<uint8_t>& sample) { return {sample.data(), sample.size()}; }

}  // namespace

CommandSample make_command_sample(const std::string& topic, const std::string& text) {
  const TopicSpec spec = find_command_topic(topic);
  return {spec, encode_text(*get_schema().find_struct(spec.type_name), text)};
}

int print_command(const CommandSample& command) {
  std::printf("%s\n",
              print_json(*get_schema().find_struct(command.topic.type_name), get_bytes(command.sample)).c_str());
  return 0;
}

int publish_command(const ToolContext& context, const CommandSample& command) {
  const auto writer = context.bus->make_writer(command.topic);
  while (!writer->has_readers()) {
    if (context.must_stop()) return 1;
    context.wait_for("a reader of " + command.topic.name + ", such as hrp-controller-ros");
    context.bus->spin(std::chrono::milliseconds(10));
  }
  spin(context, kDiscovery);
  writer->write(get_bytes(command.sample));
  spin(context, kDelivery);
  return 0;
}

}  // namespace hrp
