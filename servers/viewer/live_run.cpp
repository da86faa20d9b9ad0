// SPDX-License-Identifier: BSD-3-Clause
#include "servers/viewer/live_run.h"

#include "common/messages/topics.h"
#include "servers/viewer/signal.h"

namespace hrp {
namespace {

using Clock = std::chrono::steady_clock;

// More points than a chart has columns in the seconds that it shows.
constexpr auto kChartPeriod = std::chrono::milliseconds(2);
constexpr size_t kMostThinned = 256;   // between two ticks, so that a stall of this process costs no memory
constexpr size_t kMostWhole = 1024;

}  // namespace

struct LiveRun::Topic {
  const StructType* type = nullptr;
  bool has_header = false;
  bool whole = false;
  bool fresh = false;
  uint64_t epoch = 0;
  Clock::time_point last_kept{};
  SampleBytes latest;
  std::deque<SampleBytes> thinned;
  std::deque<SampleBytes> all;
  std::unique_ptr<Reader> reader;
};

LiveRun::LiveRun(Bus& bus, bool read_only) : bus_(bus), read_only_(read_only) {
  if (!read_only) control_ = Publisher<msg::RunControl>(bus, topics::kRunControl);
}

LiveRun::~LiveRun() = default;

void LiveRun::keep(Topic* topic, Bytes sample) {
  if (topic->has_header) {
    const uint64_t epoch = read_header(sample).epoch;
    // After a reset time begins again: nothing of the old epoch may be mixed in.
    if (epoch != topic->epoch) topic->thinned.clear();
    topic->epoch = epoch;
  }
  topic->latest.assign(sample.data, sample.data + sample.size);
  topic->fresh = true;
  if (topic->whole) {
    if (topic->all.size() >= kMostWhole) topic->all.pop_front();
    topic->all.push_back(topic->latest);
  }
  const auto now = Clock::now();
  if (now - topic->last_kept < kChartPeriod) return;
  topic->last_kept = now;
  if (topic->thinned.size() >= kMostThinned) topic->thinned.pop_front();
  topic->thinned.push_back(topic->latest);
}

void LiveRun::read_topics(const std::set<std::string>& topics, const std::set<std::string>& whole) {
  for (auto each = topics_.begin(); each != topics_.end();) {
    each = topics.count(each->first) ? std::next(each) : topics_.erase(each);
  }
  for (const std::string& name : topics) {
    const TopicSpec* known = topics::find_known_topic(name);
    const StructType* type = known ? get_schema().find_struct(known->type_name) : nullptr;
    if (!type) continue;
    std::unique_ptr<Topic>& topic = topics_[name];
    if (!topic) {
      topic = std::make_unique<Topic>();
      topic->type = type;
      topic->has_header = SampleTime(*type).has_header();
      TopicSpec spec = *known;
      spec.name = name;
      spec.depth = 64;
      const bool kept = spec.retention == Retention::kLatest;
      // What is kept for late readers is read reliably, else it would not come; it is rare and small.
      topic->reader = bus_.make_reader(spec, kept ? Delivery::kReliable : Delivery::kBestEffort,
                                       [this, at = topic.get()](Bytes sample) { keep(at, sample); });
    }
    std::lock_guard<std::recursive_mutex> lock(bus_.mutex());
    topic->whole = whole.count(name) > 0;
  }
}

std::map<std::string, std::string> LiveRun::find_topics() {
  std::map<std::string, std::string> found;
  for (const TopicSeen& topic : bus_.find_topics()) {
    const TopicSpec* known = topics::find_known_topic(topic.name);
    if (known && topic.writers > 0) found[topic.name] = known->type_name;
  }
  return found;
}

std::map<std::string, Arrivals> LiveRun::take() {
  std::map<std::string, Arrivals> taken;
  std::lock_guard<std::recursive_mutex> lock(bus_.mutex());
  for (auto& [name, topic] : topics_) {
    Arrivals& arrivals = taken[name];
    arrivals.type = topic->type;
    arrivals.fresh = topic->fresh;
    arrivals.latest = topic->latest;
    arrivals.thinned.assign(std::make_move_iterator(topic->thinned.begin()), std::make_move_iterator(topic->thinned.end()));
    arrivals.all.assign(std::make_move_iterator(topic->all.begin()), std::make_move_iterator(topic->all.end()));
    topic->thinned.clear();
    topic->all.clear();
    topic->fresh = false;
  }
  return taken;
}

bool LiveRun::request(const msg::RunControl& control) {
  if (read_only_ || !control_.has_readers()) return false;
  std::lock_guard<std::recursive_mutex> lock(bus_.mutex());
  control_.publish(control);
  return true;
}

}  // namespace hrp
