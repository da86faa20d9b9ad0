// SPDX-License-Identifier: BSD-3-Clause
#include "servers/viewer/live_run.h"

#include "common/messages/ros_topics.h"
#include "common/node/run_token.h"
#include "servers/viewer/signal.h"

namespace hrp {
namespace {

using Clock = std::chrono::steady_clock;

// More points than a chart has columns in the seconds that it shows.
constexpr auto kChartPeriod = std::chrono::milliseconds(2);
constexpr size_t kMostThinned = 256;  // between two ticks, so that a stall of this process costs no memory
constexpr size_t kMostWhole = 1024;
// A server that shows a topic at all says something four times a second.
constexpr auto kViewPatience = std::chrono::seconds(2);
constexpr auto kRepeatPeriod = std::chrono::milliseconds(100);
constexpr auto kRequestTime = std::chrono::seconds(1);  // discovery of a writer that is known to its readers takes less

}  // namespace

struct LiveRun::Topic {
  const StructType* type = nullptr;
  bool has_header = false;
  bool whole = false;
  bool fresh = false;
  HeaderWords header;  // of `latest`
  Clock::time_point wanted_since = Clock::now();
  Clock::time_point last_kept{};
  Clock::time_point last_shown{};  // came in a view
  SampleBytes latest;
  std::deque<SampleBytes> thinned;
  std::deque<SampleBytes> all;
  std::unique_ptr<Reader> reader;  // none while views have it
};

LiveRun::LiveRun(Bus& bus, bool read_only, JoinedRun run)
    : bus_(bus), read_only_(read_only), run_(std::move(run)), pictures_(bus) {
  if (!read_only) control_ = Publisher<msg::RunControl>(bus, topics::kRunControl);
}

LiveRun::~LiveRun() = default;

void LiveRun::keep(Topic* topic, Bytes sample, bool thinned) {
  if (topic->has_header) {
    const HeaderWords header = read_header(sample);
    // Said again for those who came late, or read twice: of the step that is known already.
    const bool known = header.epoch == topic->header.epoch && header.step == topic->header.step;
    if (known && !topic->latest.empty()) return;
    // After a reset time begins again: nothing of the old epoch may be mixed in.
    if (header.epoch != topic->header.epoch) topic->thinned.clear();
    topic->header = header;
  }
  topic->latest.assign(sample.data, sample.data + sample.size);
  topic->fresh = true;
  if (topic->whole) {
    if (topic->all.size() >= kMostWhole) topic->all.pop_front();
    topic->all.push_back(topic->latest);
  }
  const auto now = Clock::now();
  if (!thinned && now - topic->last_kept < kChartPeriod) return;
  topic->last_kept = now;
  if (topic->thinned.size() >= kMostThinned) topic->thinned.pop_front();
  topic->thinned.push_back(topic->latest);
}

void LiveRun::take_view(const msg::View& view) {
  const auto now = Clock::now();
  for (const msg::ViewSample& sample : view.samples()) {
    const auto found = topics_.find(sample.topic());
    if (found == topics_.end()) continue;
    Topic& topic = *found->second;
    topic.last_shown = now;
    if (!topic.reader) keep(&topic, {sample.bytes().data(), sample.bytes().size()}, true);
  }
}

void LiveRun::read_view(bool wanted) {
  if (wanted == (view_ != nullptr)) return;
  if (!wanted) return view_.reset();
  view_ = subscribe<msg::View>(bus_, topics::kView, Delivery::kBestEffort,
                               [this](const msg::View& view) { take_view(view); });
}

bool LiveRun::is_shown(const Topic& topic, Clock::time_point now) const {
  return has_view_ && (now - topic.last_shown < kViewPatience || now - topic.wanted_since < kViewPatience);
}

LiveRun::Topic* LiveRun::find_or_add(const std::string& name) {
  const TopicSpec* known = topics::find_any_topic(name);
  const StructType* type = known ? get_schema().find_struct(known->type_name) : nullptr;
  if (!type) return nullptr;
  std::lock_guard<std::recursive_mutex> lock(bus_.mutex());
  std::unique_ptr<Topic>& topic = topics_[name];
  if (!topic) {
    topic = std::make_unique<Topic>();
    topic->type = type;
    topic->has_header = SampleTime(*type).has_header();
  }
  return topic.get();
}

std::unique_ptr<Reader> LiveRun::make_reader(const std::string& name, Topic* topic) {
  TopicSpec spec = *topics::find_any_topic(name);
  spec.name = name;
  spec.depth = 64;
  const bool kept = spec.retention == Retention::kLatest;
  // What is kept for late readers is read reliably, else it would not come; it is rare and small.
  return bus_.make_reader(spec, kept ? Delivery::kReliable : Delivery::kBestEffort,
                          [this, topic](Bytes sample) { keep(topic, sample, false); });
}

void LiveRun::read_topics(const std::set<std::string>& topics, const std::set<std::string>& whole) {
  const auto now = Clock::now();
  std::vector<std::unique_ptr<Topic>> unwanted;  // end without the mutex, as bus.h asks for
  {
    std::lock_guard<std::recursive_mutex> lock(bus_.mutex());
    for (auto each = topics_.begin(); each != topics_.end();) {
      if (!topics.count(each->first)) unwanted.push_back(std::move(each->second));
      each = topics.count(each->first) ? std::next(each) : topics_.erase(each);
    }
  }
  bool any_shown = false;
  for (const std::string& name : topics) {
    Topic* topic = find_or_add(name);
    if (!topic) continue;
    const bool stream = topics::find_any_topic(name)->retention == Retention::kStream;
    std::unique_ptr<Reader> ended;
    bool direct = true;
    {
      std::lock_guard<std::recursive_mutex> lock(bus_.mutex());
      topic->whole = whole.count(name) > 0;
      direct = topic->whole || !stream || !is_shown(*topic, now);
      if (!direct) ended = std::move(topic->reader);
    }
    any_shown = any_shown || stream;
    if (direct && !topic->reader) topic->reader = make_reader(name, topic);
  }
  read_view(has_view_ && any_shown);
}

std::map<std::string, std::string> LiveRun::find_topics() {
  std::map<std::string, std::string> found;
  bool has_view = false;
  for (const TopicSeen& topic : bus_.find_topics()) {
    const TopicSpec* known = topics::find_any_topic(topic.name);
    if (!known || topic.writers == 0) continue;
    if (known == &topics::kView)
      has_view = true;  // holds samples of other topics: nothing of its own
    else
      found[topic.name] = known->type_name;
  }
  has_view_ = has_view;
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
    arrivals.thinned.assign(std::make_move_iterator(topic->thinned.begin()),
                            std::make_move_iterator(topic->thinned.end()));
    arrivals.all.assign(std::make_move_iterator(topic->all.begin()), std::make_move_iterator(topic->all.end()));
    topic->thinned.clear();
    topic->all.clear();
    topic->fresh = false;
  }
  return taken;
}

bool LiveRun::believes(const msg::RunStatus& heard, const msg::RunStatus& news) const {
  return may_believe(run_.entry.token, heard, news);
}

void LiveRun::request(const msg::RunControl& control) {
  if (read_only_) return;
  run_.entry.token = find_token(run_);
  Request request;
  request.message = control;
  request.message.nonce(make_nonce());
  sign(run_.entry.token, topics::kRunControl.type_name, &request.message);
  request.asked = request.next = Clock::now();
  requests_.push_back(std::move(request));
}

bool LiveRun::send_requests() {
  const auto now = Clock::now();
  bool nobody = false;
  for (Request& request : requests_) {
    if (now < request.next || !control_.has_readers()) continue;
    std::lock_guard<std::recursive_mutex> lock(bus_.mutex());
    control_.publish(request.message);
    request.sent = true;
    request.next = now + kRepeatPeriod;
  }
  while (!requests_.empty() && now - requests_.front().asked > kRequestTime) {
    nobody = nobody || !requests_.front().sent;
    requests_.pop_front();
  }
  return nobody;
}

}  // namespace hrp
