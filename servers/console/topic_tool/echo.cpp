// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cstdio>
#include <deque>

#include "common/base/printable.h"
#include "common/messages/reflection/sample.h"
#include "servers/console/topic_tool/topic_tool.h"

namespace hrp {
namespace {

using Clock = std::chrono::steady_clock;
using Sample = std::vector<uint8_t>;

// Callbacks only put samples here: printing to a slow terminal must not hold up the bus.
class SampleQueue {
 public:
  void add(Bytes sample) {
    if (samples_.size() == kMost) samples_.pop_front();
    samples_.emplace_back(sample.data, sample.data + sample.size);
  }

  std::deque<Sample> take(std::recursive_mutex& mutex) {
    std::lock_guard<std::recursive_mutex> lock(mutex);
    return std::exchange(samples_, {});
  }

 private:
  static constexpr size_t kMost = 4096;
  std::deque<Sample> samples_;
};

class EchoPrinter {
 public:
  EchoPrinter(const StructType& type, const EchoOptions& options) : type_(type), json_(options.json) {
    for (const std::string& text : options.fields) paths_.emplace_back(type, text);
  }

  void print(const Sample& sample) const {
    const Bytes bytes{sample.data(), sample.size()};
    std::string text;
    try {
      text = paths_.empty() ? find_whole(bytes) : json_ ? find_json_fields(bytes) : find_text_fields(bytes);
    } catch (const DecodeError& error) {
      std::fprintf(stderr, "hrp-topic: %s\n", error.what());
      return;
    }
    std::fputs(text.c_str(), stdout);
  }

 private:
  std::string find_whole(Bytes sample) const {
    return json_ ? print_json(type_, sample) + "\n" : print_text(type_, sample) + "---\n";
  }

  // {"pairs[0].total.force.z":412.5}
  std::string find_json_fields(Bytes sample) const {
    std::string text = "{";
    for (const FieldPath& path : paths_) {
      if (text.size() > 1) text += ",";
      text += "\"" + path.text() + "\":" + print_json(type_, sample, path).value_or("null");
    }
    return text + "}\n";
  }

  // One number a line, or several side by side, to be piped into other tools; parts of messages as text.
  std::string find_text_fields(Bytes sample) const {
    std::string line;
    for (const FieldPath& path : paths_) {
      std::string value = print_text(type_, sample, path).value_or("-\n");
      if (paths_.size() == 1) return value;
      value.pop_back();
      line += (line.empty() ? "" : " ") + value;
    }
    return line + "\n";
  }

  const StructType& type_;
  bool json_;
  std::vector<FieldPath> paths_;
};

}  // namespace

int echo_topic(const ToolContext& context, const EchoOptions& options) {
  const TopicSeen topic = wait_for_topic(context, options.topic);
  if (topic.name.empty()) return 0;
  const StructType* type = get_schema().find_struct(topic.type_name);
  if (!type) {
    std::fprintf(stderr, "hrp-topic: %s carries %s, which is not in our IDL\n", make_printable_line(topic.name).c_str(),
                 make_printable_line(topic.type_name).c_str());
    return 1;
  }
  const EchoPrinter printer(*type, options);
  SampleQueue queue;
  const auto reader = make_inspector(*context.bus, topic, [&](Bytes sample) { queue.add(sample); });
  const auto pause = std::chrono::duration<double>(options.rate > 0 ? 1.0 / options.rate : 0.0);
  long printed = 0;
  auto next = Clock::now();
  while (true) {
    const bool stop = context.must_stop();  // asked first: what came before the end is still printed
    for (const Sample& sample : queue.take(context.bus->mutex())) {
      if (options.rate > 0 && Clock::now() < next) continue;
      next = Clock::now() + std::chrono::duration_cast<Clock::duration>(pause);
      printer.print(sample);
      if (++printed == options.count) return 0;
    }
    std::fflush(stdout);
    if (stop || std::ferror(stdout)) return 0;
    context.bus->spin(std::chrono::milliseconds(5));
  }
}

}  // namespace hrp
