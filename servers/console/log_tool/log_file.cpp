// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/log_tool/log_file.h"

#include "common/base/diagnostics.h"
#include "common/messages/topics.h"

namespace hrp {

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
  Diagnostic problem;
  problem.file = reader_.path();
  problem.message = meant.empty() ? "no topic '" + name + "'; it has:" : "'" + name + "' may be:";
  for (const std::string& topic : meant.empty() ? names : meant) problem.message += " " + topic;
  throw InputError(problem);
}

}  // namespace hrp
