// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <filesystem>

#include "common/mcap/reader.h"
#include "common/messages/cdr.h"
#include "common/messages/logged_description.h"
#include "common/messages/topics.h"
#include "hrp_idl/dynamics.h"
#include "servers/viewer/recording.h"

namespace hrp {
namespace {

void add_topics(const mcap::Reader& reader, Recording* recording, PictureLog* pictures) {
  for (const auto& [id, channel] : reader.channels()) {
    const auto schema = reader.schemas().find(channel.schema_id);
    const bool known = schema != reader.schemas().end() && channel.message_encoding == "cdr";
    // As our logger writes them, and as hrp-log and ROS 2 do: the bytes are the same.
    if (known && is_picture(schema->second.name)) {
      pictures->add_topic(id, channel.topic, schema->second.name);
      continue;
    }
    if (!known || schema->second.encoding != "omgidl") {
      recording->add_note(channel.topic + " is no CDR with an omgidl schema: left out");
      continue;
    }
    try {
      // The log's own schema: it may be older than this program.
      const StructType* type = recording->add_schema(schema->second.text, schema->second.name);
      recording->add_topic(channel.topic, type, schema->second.text);
    } catch (const std::exception& error) {
      recording->add_note(channel.topic + ": its schema cannot be read: " + error.what());
    }
  }
}

// "fell at t = 0.412 s: the robot has fallen: ..."; empty for other events, and for one that is not as ours are today.
std::string describe_fall(Bytes sample) {
  msg::RobotEvent event;
  try {
    decode(sample, &event);
  } catch (const DecodeError&) {
    return "";
  }
  if (event.kind() != msg::EVENT_FALL) return "";
  char time[60];
  std::snprintf(time, sizeof time, "fell at t = %.3f s: ", event.header().time());
  return time + event.text();
}

}  // namespace

std::unique_ptr<Recording> read_log(const std::string& path) {
  const auto file = std::make_shared<mcap::Reader>(path);  // the pictures stay in it
  mcap::Reader& reader = *file;
  auto recording = std::make_unique<Recording>(std::filesystem::path(path).filename().string());
  auto pictures = std::make_unique<PictureLog>(file);
  add_topics(reader, recording.get(), pictures.get());
  std::map<uint16_t, std::pair<std::string, SampleTime>> known;
  for (const auto& [id, channel] : reader.channels()) {
    const auto topic = recording->topics().find(channel.topic);
    if (topic != recording->topics().end())
      known.emplace(id, std::make_pair(channel.topic, SampleTime(*topic->second.type)));
  }
  reader.read_messages([&](const mcap::Message& message) {
    const auto found = known.find(message.channel_id);
    if (found == known.end()) {
      pictures->add(message);
      return true;
    }
    const auto& [topic, time] = found->second;
    const Bytes sample{message.data, message.size};
    if (topic == topics::kRobotDescription.name) {
      msg::RobotDescription description;
      decode_logged(sample, &description);
      recording->set_scene(make_scene(description));
    }
    if (topics::find_known_topic(topic) == &topics::kEvents) {
      if (const std::string fall = describe_fall(sample); !fall.empty()) recording->add_note(fall);
    }
    recording->add(topic, time.has_header() ? time.find(sample) : 1e-9 * static_cast<double>(message.log_time), sample);
    return true;
  });
  if (!reader.damage().empty()) recording->add_note("the file was cut short: " + reader.damage());
  if (!pictures->topics().empty()) recording->set_pictures(std::move(pictures));
  recording->finish();
  return recording;
}

}  // namespace hrp
