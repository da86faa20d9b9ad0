// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cstdio>
#include <stdexcept>

#include "common/base/diagnostics.h"
#include "common/base/join_words.h"
#include "common/base/printable.h"
#include "common/messages/reflection/schema.h"
#include "common/messages/ros_topics.h"
#include "servers/console/topic_tool/topic_tool.h"

namespace hrp {

namespace {

// Two topics that a short name may mean are both looked for this long before one of them is taken.
constexpr auto kDiscovery = std::chrono::milliseconds(300);

std::string join(const std::vector<std::string>& names) { return join_words(names, make_printable_line); }

// Topics that somebody writes.
std::vector<TopicSeen> find_written(Bus& bus) {
  std::vector<TopicSeen> written;
  for (const TopicSeen& topic : bus.find_topics()) {
    if (topic.writers > 0) written.push_back(topic);
  }
  return written;
}

std::string describe_wait(const std::string& name, const std::vector<std::string>& names) {
  const std::string nearest = find_nearest(name, names);
  if (names.empty()) return name + "; nothing is written there yet";
  return name + ", which nobody writes" + (nearest.empty() ? "" : "; is it " + make_printable_line(nearest) + "?") +
         " (written: " + join(names) + ")";
}

}  // namespace

TopicSeen wait_for_topic(const ToolContext& context, const std::string& name) {
  const auto start = std::chrono::steady_clock::now();
  while (!context.must_stop()) {
    const std::vector<TopicSeen> written = find_written(*context.bus);
    std::vector<std::string> names;
    for (const TopicSeen& topic : written) names.push_back(topic.name);
    const std::vector<std::string> meant = topics::find_meant_topics(name, names);
    if (meant.size() > 1) throw std::runtime_error("'" + name + "' may be " + join(meant));
    const bool sure = meant.size() == 1 && (meant[0] == name || std::chrono::steady_clock::now() - start > kDiscovery);
    for (const TopicSeen& topic : written) {
      if (sure && topic.name == meant[0]) return topic;
    }
    if (meant.empty()) context.wait_for(describe_wait(name, names));
    context.bus->spin(std::chrono::milliseconds(10));
  }
  return {};
}

std::unique_ptr<Reader> make_inspector(Bus& bus, const TopicSeen& topic, SampleCallback callback) {
  TopicSpec spec;
  spec.name = topic.name;
  spec.type_name = topic.type_name;
  spec.depth = 64;
  const TopicSpec* known = topics::find_any_topic(topic.name);
  const bool kept = known && known->retention == Retention::kLatest;
  if (kept) spec.retention = Retention::kLatest;
  return bus.make_reader(spec, kept ? Delivery::kReliable : Delivery::kBestEffort, std::move(callback));
}

int print_type(const std::string& name) {
  const TopicSpec* topic = topics::find_any_topic(name);
  for (const char* prefix : {"hrp/", "rt/"}) {
    if (!topic) topic = topics::find_any_topic(prefix + name);
  }
  std::string text = find_schema_text(topic ? topic->type_name : name);
  if (text.empty()) text = find_schema_text("hrp::msg::" + name);
  if (text.empty()) {
    std::fprintf(stderr, "hrp-topic: no type or topic '%s' in our IDL; types:\n", name.c_str());
    for (const std::string& each : get_schema().find_struct_names()) std::fprintf(stderr, "  %s\n", each.c_str());
    return 2;
  }
  std::fputs(text.c_str(), stdout);
  return 0;
}

}  // namespace hrp
