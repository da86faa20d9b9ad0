// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cstdio>

#include "common/base/diagnostics.h"
#include "common/messages/reflection/schema.h"
#include "common/messages/topics.h"
#include "servers/console/topic_tool/topic_tool.h"

namespace hrp {

TopicSeen wait_for_topic(const ToolContext& context, const std::string& name) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  bool told = false;
  while (!context.must_stop()) {
    std::vector<std::string> names;
    for (const TopicSeen& topic : context.bus->find_topics()) {
      if (topic.name == name && topic.writers > 0) return topic;
      names.push_back(topic.name);
    }
    if (!told && Clock::now() - start > std::chrono::seconds(1)) {
      const std::string nearest = find_nearest(name, names);
      std::fprintf(stderr, "waiting: nobody writes %s%s\n", name.c_str(),
                   nearest.empty() ? "" : (", is it " + nearest + "?").c_str());
      told = true;
    }
    context.bus->spin(std::chrono::milliseconds(10));
  }
  return {};
}

std::unique_ptr<Reader> make_inspector(Bus& bus, const TopicSeen& topic, SampleCallback callback) {
  TopicSpec spec;
  spec.name = topic.name;
  spec.type_name = topic.type_name;
  spec.depth = 64;
  const TopicSpec* known = topics::find_known_topic(topic.name);
  const bool kept = known && known->retention == Retention::kLatest;
  if (kept) spec.retention = Retention::kLatest;
  return bus.make_reader(spec, kept ? Delivery::kReliable : Delivery::kBestEffort, std::move(callback));
}

int print_type(const std::string& name) {
  const TopicSpec* topic = topics::find_known_topic(name);
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
