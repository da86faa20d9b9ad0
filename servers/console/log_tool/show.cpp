// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>

#include "common/base/printable.h"
#include "servers/console/log_tool/commands.h"
#include "servers/console/log_tool/log_file.h"

namespace hrp {
namespace {

struct TopicCount {
  uint64_t messages = 0, bytes = 0;
  uint64_t first_step = 0, last_step = 0;
  double first_time = 0, last_time = 0;  // [s]
};

}  // namespace

int show_info(const std::string& file) {
  LogFile log(file);
  std::map<uint16_t, TopicCount> counts;
  log.reader().read_messages([&](const mcap::Message& message) {
    TopicCount& count = counts[message.channel_id];
    const double time = static_cast<double>(message.log_time) * 1e-9;
    if (count.messages++ == 0) {
      count.first_step = message.sequence;
      count.first_time = time;
    }
    count.bytes += message.size;
    count.last_step = message.sequence;
    count.last_time = time;
    return true;
  });
  std::printf("%s: %.1f MB, %zu chunks, %s\n", file.c_str(), static_cast<double>(log.reader().file_size()) * 1e-6,
              log.reader().chunk_count(), log.reader().indexed() ? "closed and indexed" : "not closed");
  size_t longest = 24;
  for (const auto& [id, topic] : log.topics()) longest = std::max(longest, topic.topic.size());
  const int width = static_cast<int>(std::min<size_t>(longest, 60));
  std::printf("%-*s %-28s %10s %10s %10s %10s %12s\n", width, "topic", "type", "messages", "MB", "first step",
              "last step", "last time/s");
  for (const auto& [id, topic] : log.topics()) {
    const TopicCount& count = counts[id];
    std::printf("%-*s %-28s %10llu %10.2f %10llu %10llu %12.4f\n", width, make_printable_line(topic.topic).c_str(),
                topic.type != nullptr ? topic.type->name.c_str() : "?", static_cast<unsigned long long>(count.messages),
                static_cast<double>(count.bytes) * 1e-6, static_cast<unsigned long long>(count.first_step),
                static_cast<unsigned long long>(count.last_step), count.last_time);
  }
  return say_damage(log.reader());
}

int show_messages(const CatOptions& options) {
  LogFile log(options.file);
  std::set<std::string> wanted;
  std::map<uint16_t, FieldPath> paths;
  if (!options.topic.empty()) wanted.insert(log.find_topic(options.topic).topic);
  for (const auto& [id, topic] : log.topics()) {
    const bool shown = wanted.empty() || wanted.count(topic.topic) > 0;
    if (shown && !options.field.empty() && topic.type != nullptr) {
      paths.emplace(id, FieldPath(*topic.type, options.field));
    }
  }
  log.reader().read_messages(
      [&](const mcap::Message& message) {
        const double time = static_cast<double>(message.log_time) * 1e-9;
        const LogTopicType& topic = log.topics().at(message.channel_id);
        if (time < options.from || topic.type == nullptr) return true;
        if (options.to >= 0 && time > options.to) return false;
        std::optional<std::string> text;
        const auto path = paths.find(message.channel_id);
        const Bytes sample = get_bytes(message);
        if (path != paths.end()) {
          text = options.json ? print_json(*topic.type, sample, path->second)
                              : print_text(*topic.type, sample, path->second);
        } else {
          text = options.json ? print_json(*topic.type, sample) : print_text(*topic.type, sample);
        }
        if (!text) return true;
        if (options.json) {
          return std::printf("{\"topic\":\"%s\",\"step\":%u,\"time\":%.9g,\"message\":%s}\n",
                             make_printable_line(topic.topic).c_str(), message.sequence, time, text->c_str()) >= 0;
        }
        const char* end = text->empty() || text->back() != '\n' ? "\n" : "";
        return std::printf("--- %s step %u, %.9g s\n%s%s", make_printable_line(topic.topic).c_str(), message.sequence,
                           time, text->c_str(), end) >= 0;
      },
      wanted);
  return say_damage(log.reader());
}

}  // namespace hrp
