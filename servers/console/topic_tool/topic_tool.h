// SPDX-License-Identifier: BSD-3-Clause
// What hrp-topic does. All functions return an exit code and end early when a stop signal comes.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/bus/bus.h"

namespace hrp {

struct EchoOptions {
  std::string topic;
  bool json = false;
  long count = 0;                   // samples to print, 0 = no end
  double rate = 0.0;                // [1/s of wall clock] at most, 0 = all
  std::vector<std::string> fields;  // paths; empty = whole messages
};

// What the tool needs to know of its surroundings.
struct ToolContext {
  Bus* bus = nullptr;
  std::function<bool()> must_stop;                        // signal, or the run has ended
  std::function<void(const std::string& what)> wait_for;  // called over and over while something is missing
};

// A table of topics with types, ends and the rate measured over `seconds`.
int list_topics(const ToolContext& context, double seconds, bool json);
// Prints samples as they come.
int echo_topic(const ToolContext& context, const EchoOptions& options);
// Prints rate, gaps and size once a second.
int measure_topic(const ToolContext& context, const std::string& topic, long count);
// Prints the IDL of a type or of a topic's type, everything it needs included.
int print_type(const std::string& name);

// A message that commands the robot.
struct CommandSample {
  TopicSpec topic;
  std::vector<uint8_t> sample;
};
// `text`: see sample_text.h. Throws std::runtime_error when the topic takes no commands or the text is no message of
// it.
CommandSample make_command_sample(const std::string& topic, const std::string& text);
// Prints it as one line of JSON.
int print_command(const CommandSample& command);
// Sends it once somebody reads the topic.
int publish_command(const ToolContext& context, const CommandSample& command);

// Waits until somebody offers the topic: `name` in full, or its last parts where one topic has them (contact_forces,
// imu/chest). Throws std::runtime_error when several have them. Empty when told to stop before.
TopicSeen wait_for_topic(const ToolContext& context, const std::string& name);
// Best effort, so that looking never slows a run; retained topics are read reliably, for the sample that is kept.
std::unique_ptr<Reader> make_inspector(Bus& bus, const TopicSeen& topic, SampleCallback callback);

}  // namespace hrp
