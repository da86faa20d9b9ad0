// SPDX-License-Identifier: BSD-3-Clause
#include "servers/viewer/recording.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "common/base/diagnostics.h"
#include "common/messages/reflection/sample.h"

namespace hrp {
namespace {

using Json = nlohmann::json;

// What a laptop has to spare. A minute of a humanoid at 1 kHz is about 250 MB.
constexpr size_t kMostBytes = size_t{1500} << 20;
// Half a step of the finest clock: times are compared as people mean them.
constexpr double kSameTime = 1e-9;  // [s]

}  // namespace

Series thin_out(const Series& series, size_t most) {
  Series kept;
  kept.unit = series.unit;
  const size_t count = series.times.size();
  const size_t stretches = std::max<size_t>(1, most / 2);
  const size_t length = std::max<size_t>(1, (count + stretches - 1) / stretches);
  for (size_t begin = 0; begin < count; begin += length) {
    const size_t end = std::min(begin + length, count);
    size_t low = end, high = end;
    for (size_t i = begin; i < end; ++i) {
      if (!std::isfinite(series.values[i])) continue;
      if (low == end || series.values[i] < series.values[low]) low = i;
      if (high == end || series.values[i] > series.values[high]) high = i;
    }
    if (low == end) continue;
    for (const size_t i : {std::min(low, high), std::max(low, high)}) {
      kept.times.push_back(series.times[i]);
      kept.values.push_back(series.values[i]);
      if (low == high) break;
    }
  }
  return kept;
}

Series subtract(const Series& first, double begin_first, const Series& second, double begin_second) {
  Series difference;
  difference.unit = first.unit;
  size_t at = 0;
  for (size_t i = 0; i < first.times.size(); ++i) {
    const double time = first.times[i] - begin_first + begin_second;
    while (at + 1 < second.times.size() && second.times[at + 1] < time - kSameTime) ++at;
    if (at + 1 >= second.times.size() || time < second.times[at] - kSameTime || time > second.times.back() + kSameTime)
      continue;
    const double span = second.times[at + 1] - second.times[at];
    const double share = span > 0 ? std::clamp((time - second.times[at]) / span, 0.0, 1.0) : 0.0;
    // At samples that both have the value is the second one's own, to the bit.
    const double value = share < 1e-6       ? second.values[at]
                         : share > 1 - 1e-6 ? second.values[at + 1]
                                            : second.values[at] + share * (second.values[at + 1] - second.values[at]);
    difference.times.push_back(first.times[i]);
    difference.values.push_back(first.values[i] - value);
  }
  return difference;
}

const StructType* Recording::add_schema(const std::string& text, const std::string& type_name) {
  schemas_.push_back(std::make_unique<Schema>(parse_idl({{type_name, text}})));
  return schemas_.back()->find_struct(type_name);
}

void Recording::add_topic(const std::string& topic, const StructType* type, const std::string& schema_text) {
  if (!type) return;
  Topic& added = topics_[topic];
  added.type = type;
  added.schema_text = schema_text;
}

void Recording::add(const std::string& topic, double time, Bytes sample) {
  Topic& all = topics_.at(topic);
  if (counts_[topic]++ % static_cast<size_t>(stride_) != 0) return;
  all.samples.push_back({time, std::vector<uint8_t>(sample.data, sample.data + sample.size)});
  bytes_ += sample.size;
  if (bytes_ < kMostBytes) return;
  stride_ *= 2;
  bytes_ = 0;
  for (auto& [name, each] : topics_) {
    std::vector<Sample> half;
    for (size_t i = 0; i < each.samples.size(); i += 2) half.push_back(std::move(each.samples[i]));
    each.samples = std::move(half);
    for (const Sample& kept : each.samples) bytes_ += kept.bytes.size();
  }
}

void Recording::finish() {
  if (stride_ > 1) add_note("long recording: every " + std::to_string(stride_) + "th sample is shown");
  bool any = false;
  for (auto& [name, topic] : topics_) {
    auto& samples = topic.samples;
    // A damaged clock must not break the search for a time.
    std::stable_sort(samples.begin(), samples.end(), [](const Sample& a, const Sample& b) { return a.time < b.time; });
    // A sample alone (the description) says nothing of when.
    if (samples.size() < 2) continue;
    begin_ = any ? std::min(begin_, samples.front().time) : samples.front().time;
    end_ = any ? std::max(end_, samples.back().time) : samples.back().time;
    any = true;
  }
}

const Recording::Sample* Recording::find_sample(const Topic& topic, double time) const {
  const auto after = std::upper_bound(topic.samples.begin(), topic.samples.end(), time + kSameTime,
                                      [](double t, const Sample& sample) { return t < sample.time; });
  return after == topic.samples.begin() ? nullptr : &*std::prev(after);
}

std::string Recording::make_frame(double time) const {
  std::string text = "{\"time\":" + Json(time).dump() + ",\"topics\":{";
  bool first = true;
  for (const auto& [name, topic] : topics_) {
    // The description went to the page as its scene.
    if (topic.type->name == "hrp::msg::RobotDescription") continue;
    const Sample* sample = find_sample(topic, time);
    if (!sample) continue;
    try {
      text += (first ? "\"" : ",\"") + name + "\":" + print_json(*topic.type, sample->get());
      first = false;
    } catch (const DecodeError&) {
      // One bad sample of one topic is no reason to show nothing.
    }
  }
  return text + "}}";
}

const Recording::Topic* Recording::find_motion() const {
  for (const char* name : {"hrp/robot_state", "hrp/sensor_data"}) {
    const auto found = topics_.find(name);
    if (found != topics_.end() && found->second.samples.size() > 1) return &found->second;
  }
  return nullptr;
}

double Recording::find_step(double time, int count) const {
  const Topic* topic = find_motion();
  if (!topic) return time;
  const Sample* now = find_sample(*topic, time);
  const long at = now ? now - topic->samples.data() : -1;
  // Back from between two samples is the one before.
  const long target = std::clamp<long>(at + count, 0, static_cast<long>(topic->samples.size()) - 1);
  return topic->samples[static_cast<size_t>(target)].time;
}

Series Recording::find_series(const std::string& signal) const {
  const SignalName name = split_signal(signal);
  const auto found = topics_.find(name.topic);
  if (found == topics_.end()) refuse_input({"", signal}, name_ + " has no topic " + name.topic);
  const Signal reader(*found->second.type, name.path, scene_.joints, scene_.ground_height);
  Series series;
  series.unit = reader.unit();
  for (const Sample& sample : found->second.samples) {
    double value = kNoValue;
    try {
      value = reader.find(sample.get());
    } catch (const DecodeError&) {
    }
    if (!std::isfinite(value)) continue;
    series.times.push_back(sample.time);
    series.values.push_back(value);
  }
  return series;
}

}  // namespace hrp
