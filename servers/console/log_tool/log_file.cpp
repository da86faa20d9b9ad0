// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/log_tool/log_file.h"

#include <array>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "common/base/diagnostics.h"
#include "common/base/printable.h"
#include "common/mcap/claimed_file.h"
#include "common/messages/topics.h"
#include "servers/console/log_tool/commands.h"

namespace hrp {
namespace {

bool is_log(const std::string& path) {
  std::array<char, mcap::kMagic.size()> start{};
  std::ifstream file(path, std::ios::binary);
  return file.read(start.data(), start.size()) && std::memcmp(start.data(), mcap::kMagic.data(), start.size()) == 0;
}

}  // namespace

void check_output(const std::string& in, const std::string& out, bool force) {
  if (mcap::is_same_file(in, out)) refuse_input(out, "is the log that is read; give the output another name");
  if (!force && is_log(out)) refuse_input(out, "is a log; choose another name, or --force to overwrite it");
}

LogFile::LogFile(const std::string& path) : reader_(path) {
  for (const auto& [id, channel] : reader_.channels()) {
    LogTopicType topic;
    topic.topic = channel.topic;
    const auto found = reader_.schemas().find(channel.schema_id);
    if (found != reader_.schemas().end() && found->second.encoding == "omgidl") {
      topic.schema = std::make_shared<Schema>(parse_idl({{found->second.name, found->second.text}}));
      topic.type = topic.schema->find_struct(found->second.name);
    }
    if (topic.type != nullptr && !topic.type->fields.empty()) {
      const FieldType& first = topic.type->fields.front().type;
      topic.stepped = first.structure != nullptr && first.structure->name == "hrp::msg::Header";
    }
    topics_.emplace(id, std::move(topic));
  }
}

const LogTopicType& LogFile::find_topic(const std::string& name) const {
  std::vector<std::string> names;
  for (const auto& [id, topic] : topics_) names.push_back(topic.topic);
  const std::vector<std::string> meant = topics::find_meant_topics(name, names);
  for (const auto& [id, topic] : topics_) {
    if (meant.size() == 1 && topic.topic == meant[0]) return topic;
  }
  std::string problem = meant.empty() ? "no topic '" + name + "'; it has:" : "'" + name + "' may be:";
  if (names.empty()) problem += " none";
  for (const std::string& topic : meant.empty() ? names : meant) problem += " " + topic;
  refuse_input(reader_.path(), problem);
}

int say_damage(const mcap::Reader& reader) {
  if (reader.damage().empty()) return 0;
  std::fprintf(stderr, "%s\n", make_printable_line(reader.damage()).c_str());
  return 1;
}

}  // namespace hrp
