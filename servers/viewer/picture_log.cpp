// SPDX-License-Identifier: BSD-3-Clause
#include "servers/viewer/picture_log.h"

#include <algorithm>
#include <cmath>

namespace hrp {
namespace {

// [s] -> [ns]; half a step of the finest clock later, as Recording::find_sample() does. A page may ask for any time.
uint64_t make_log_time(double time) {
  constexpr double kLast = 9.2e9;  // [s], nearly 2^63 ns
  return std::isfinite(time) ? static_cast<uint64_t>(std::llround(std::clamp(time, 0.0, kLast) * 1e9)) + 1 : 0;
}

}  // namespace

void PictureLog::add_topic(uint16_t channel, const std::string& topic, const std::string& type) {
  Topic& added = topics_[topic];
  added.channel = channel;
  added.type = type;
  names_[channel] = topic;
}

void PictureLog::add(const mcap::Message& message) {
  const auto name = names_.find(message.channel_id);
  if (name == names_.end()) return;
  std::vector<Place>& places = topics_.at(name->second).places;
  const bool same = !places.empty() && places.back().chunk == message.chunk;
  Place place{message.log_time, message.chunk, same ? places.back().index + 1 : 0};
  // A damaged clock must not break the search for a time.
  if (!places.empty()) place.log_time = std::max(place.log_time, places.back().log_time);
  places.push_back(place);
}

std::map<std::string, std::string> PictureLog::topics() const {
  std::map<std::string, std::string> found;
  for (const auto& [name, topic] : topics_) found[name] = topic.type;
  return found;
}

std::string PictureLog::find_type(const std::string& topic) const {
  const auto found = topics_.find(topic);
  return found == topics_.end() ? "" : found->second.type;
}

uint64_t PictureLog::find(const std::string& topic, double time) const {
  const auto found = topics_.find(topic);
  if (found == topics_.end()) return 0;
  const std::vector<Place>& places = found->second.places;
  const auto after = std::upper_bound(places.begin(), places.end(), make_log_time(time),
                                      [](uint64_t t, const Place& place) { return t < place.log_time; });
  return static_cast<uint64_t>(after - places.begin());
}

PictureBytes PictureLog::read(const std::string& topic, uint64_t number) {
  const auto found = topics_.find(topic);
  if (found == topics_.end() || number == 0 || number > found->second.places.size()) return nullptr;
  const Place& place = found->second.places[number - 1];
  PictureBytes sample;
  size_t index = 0;
  reader_->read_chunk(place.chunk, [&](const mcap::Message& message) {
    if (message.channel_id != found->second.channel || index++ != place.index) return true;
    sample = std::make_shared<const std::vector<uint8_t>>(message.data, message.data + message.size);
    return false;
  });
  return sample;
}

}  // namespace hrp
