// SPDX-License-Identifier: BSD-3-Clause
// What Foxglove clients are sent: samples as they are, and the scene made from them.
#include <algorithm>

#include "servers/viewer/foxglove_client.h"
#include "servers/viewer/viewer.h"

namespace hrp {
namespace {

Bytes get_bytes(const SampleBytes& sample) { return {sample.data(), sample.size()}; }

}  // namespace

void Viewer::show_time(double time) {
  if (live_ || recordings_.empty()) return;
  shown_time_ = time;
  for (const auto& [name, topic] : recordings_[0]->topics()) {
    const Recording::Sample* sample = recordings_[0]->find_sample(topic, time);
    if (!sample) continue;
    for (FoxgloveClient* client : foxgloves_) client->send(name, sample->get(), sample->time);
  }
  show_foxglove_scene(time);
}

void Viewer::show_foxglove_scene(double time) {
  for (const FoxgloveScene::Channel& channel : FoxgloveScene::channels()) {
    const auto source = recordings_[0]->topics().find(channel.source);
    if (!reads_foxglove(channel.topic) || source == recordings_[0]->topics().end()) continue;
    const Recording::Sample* sample = recordings_[0]->find_sample(source->second, time);
    if (!sample) continue;
    const std::string json = foxglove_scene_.make(channel, sample->time, sample->get());
    if (json.empty()) continue;
    const Bytes bytes{reinterpret_cast<const uint8_t*>(json.data()), json.size()};
    for (FoxgloveClient* client : foxgloves_) client->send(channel.topic, bytes, sample->time);
  }
}

bool Viewer::reads_foxglove(const std::string& topic) const {
  return std::any_of(foxgloves_.begin(), foxgloves_.end(), [&](auto* client) { return client->reads(topic); });
}

void Viewer::send_foxglove(const std::map<std::string, Arrivals>& arrivals) {
  if (foxgloves_.empty()) return;
  send_foxglove_scene(arrivals);
  for (const auto& [name, topic] : arrivals) {
    const SampleTime time(*topic.type);
    for (FoxgloveClient* client : foxgloves_) {
      for (const SampleBytes& sample : topic.all) {
        client->send(name, get_bytes(sample), time.known() ? time.find(get_bytes(sample)) : run_status_.time());
      }
      // What is kept for late comers comes once, to each who subscribes.
      if (topic.latest.empty()) continue;
      client->send(name, get_bytes(topic.latest),
                   time.known() ? time.find(get_bytes(topic.latest)) : run_status_.time(), false);
    }
  }
}

void Viewer::send_foxglove_scene(const std::map<std::string, Arrivals>& arrivals) {
  for (const FoxgloveScene::Channel& channel : FoxgloveScene::channels()) {
    const auto source = arrivals.find(channel.source);
    if (!reads_foxglove(channel.topic) || source == arrivals.end() || source->second.latest.empty()) continue;
    const SampleTime sample_time(*source->second.type);
    const Bytes sample = get_bytes(source->second.latest);
    const double time = sample_time.known() ? sample_time.find(sample) : run_status_.time();
    const std::string json = foxglove_scene_.make(channel, time, sample);
    if (json.empty()) continue;
    const Bytes bytes{reinterpret_cast<const uint8_t*>(json.data()), json.size()};
    // To those who have come since, also when nothing is new.
    for (FoxgloveClient* client : foxgloves_) client->send(channel.topic, bytes, time, source->second.fresh);
  }
}

}  // namespace hrp
