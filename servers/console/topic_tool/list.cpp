// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cstdio>
#include <map>

#include "common/base/printable.h"
#include "servers/console/topic_tool/topic_tool.h"

namespace hrp {
namespace {

using Clock = std::chrono::steady_clock;

struct Traffic {
  std::unique_ptr<Reader> reader;
  uint64_t samples = 0;
  uint64_t bytes = 0;
  Clock::time_point first;  // of the samples
  Clock::time_point last;
  double find_rate() const {
    const double elapsed = std::chrono::duration<double>(last - first).count();
    return elapsed > 0 ? static_cast<double>(samples - 1) / elapsed : 0.0;
  }
};

// Reads every topic that somebody writes and counts.
class TrafficCount {
 public:
  explicit TrafficCount(Bus& bus) : bus_(bus) {}

  // New topics may show up at any time.
  void join_new_topics() {
    for (const TopicSeen& topic : bus_.find_topics()) {
      if (topic.writers == 0 || traffic_.count(topic.name)) continue;
      Traffic& traffic = traffic_[topic.name];
      TopicSpec spec;
      spec.name = topic.name;
      spec.type_name = topic.type_name;
      spec.depth = 64;
      traffic.reader = bus_.make_reader(spec, Delivery::kBestEffort, [&traffic](Bytes sample) {
        traffic.last = Clock::now();
        if (++traffic.samples == 1) traffic.first = traffic.last;
        traffic.bytes += sample.size;
      });
    }
  }

  const Traffic* find(const std::string& topic) const {
    const auto found = traffic_.find(topic);
    return found == traffic_.end() ? nullptr : &found->second;
  }

 private:
  Bus& bus_;
  std::map<std::string, Traffic> traffic_;
};

void print_json_line(const TopicSeen& topic, int readers, double rate, double bytes) {
  std::printf(
      "{\"topic\":\"%s\",\"type\":\"%s\",\"writers\":%d,\"readers\":%d,\"rate\":%.6g,\"bytes_per_second\":%.6g}\n",
      make_printable_line(topic.name).c_str(), make_printable_line(topic.type_name).c_str(), topic.writers, readers,
      rate, bytes);
}

}  // namespace

int list_topics(const ToolContext& context, double seconds, bool json) {
  TrafficCount count(*context.bus);
  // Discovery takes some milliseconds on loopback; what comes later (other vendors: up to a second) is still joined.
  const auto end = Clock::now() + std::chrono::milliseconds(300) + std::chrono::duration<double>(seconds);
  while (Clock::now() < end && !context.must_stop()) {
    count.join_new_topics();
    context.bus->spin(std::chrono::milliseconds(20));
  }
  std::lock_guard<std::recursive_mutex> lock(context.bus->mutex());
  if (!json) std::printf("%-32s %-40s %7s %7s %10s %10s\n", "TOPIC", "TYPE", "WRITERS", "READERS", "RATE 1/s", "kB/s");
  for (const TopicSeen& topic : context.bus->find_topics()) {
    const Traffic* traffic = count.find(topic.name);
    const int readers = topic.readers - (traffic ? 1 : 0);  // not this tool
    const double rate = traffic ? traffic->find_rate() : 0.0;
    const double bytes =
        rate > 0 ? rate * static_cast<double>(traffic->bytes) / static_cast<double>(traffic->samples) : 0.0;
    if (json) {
      print_json_line(topic, readers, rate, bytes);
    } else {
      std::printf("%-32s %-40s %7d %7d %10.1f %10.1f\n", make_printable_line(topic.name).c_str(),
                  make_printable_line(topic.type_name).c_str(), topic.writers, readers, rate, bytes / 1000);
    }
  }
  return 0;
}

int measure_topic(const ToolContext& context, const std::string& name, long count) {
  const TopicSeen topic = wait_for_topic(context, name);
  if (topic.name.empty()) return 0;
  uint64_t samples = 0, bytes = 0;
  double longest_gap = 0.0;
  Clock::time_point last = Clock::now();
  const auto reader = make_inspector(*context.bus, topic, [&](Bytes sample) {
    const auto now = Clock::now();
    if (samples > 0) longest_gap = std::max(longest_gap, std::chrono::duration<double>(now - last).count());
    last = now;
    ++samples;
    bytes += sample.size;
  });
  for (long line = 0; (count == 0 || line < count) && !context.must_stop() && !std::ferror(stdout); ++line) {
    const auto start = Clock::now();
    while (Clock::now() < start + std::chrono::seconds(1) && !context.must_stop()) {
      context.bus->spin(std::chrono::milliseconds(20));
    }
    std::lock_guard<std::recursive_mutex> lock(context.bus->mutex());
    const double elapsed = std::chrono::duration<double>(Clock::now() - start).count();
    std::printf("%10.1f 1/s  %8.1f bytes a sample  longest gap %.3f ms\n", static_cast<double>(samples) / elapsed,
                samples ? static_cast<double>(bytes) / static_cast<double>(samples) : 0.0, longest_gap * 1000);
    std::fflush(stdout);
    samples = bytes = 0;
    longest_gap = 0.0;
  }
  return 0;
}

}  // namespace hrp
