// SPDX-License-Identifier: BSD-3-Clause
#include "servers/viewer/live_pictures.h"

#include "common/messages/ros_topics.h"

namespace hrp {

void LivePictures::read_topics(const std::set<std::string>& topics) {
  for (auto each = topics_.begin(); each != topics_.end();) {
    each = topics.count(each->first) ? std::next(each) : topics_.erase(each);
  }
  for (const std::string& name : topics) {
    if (topics_.count(name) || !is_picture_topic(name)) continue;
    Topic* topic = (topics_[name] = std::make_unique<Topic>()).get();
    TopicSpec spec = *topics::find_any_topic(name);
    spec.name = name;
    spec.depth = 1;
    topic->reader = bus_.make_reader(spec, Delivery::kBestEffort, [this, topic](Bytes sample) {
      topic->newest = std::make_shared<const std::vector<uint8_t>>(sample.data, sample.data + sample.size);
      topic->number = ++count_;
    });
  }
}

std::string LivePictures::find_type(const std::string& topic) const {
  return is_picture_topic(topic) ? topics::find_any_topic(topic)->type_name : "";
}

uint64_t LivePictures::find(const std::string& topic, double) const {
  std::lock_guard<std::recursive_mutex> lock(bus_.mutex());
  const auto found = topics_.find(topic);
  return found == topics_.end() ? 0 : found->second->number;
}

PictureBytes LivePictures::read(const std::string& topic, uint64_t) {
  std::lock_guard<std::recursive_mutex> lock(bus_.mutex());
  const auto found = topics_.find(topic);
  return found == topics_.end() ? nullptr : found->second->newest;
}

}  // namespace hrp
