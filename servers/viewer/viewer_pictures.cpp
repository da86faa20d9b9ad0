// SPDX-License-Identifier: BSD-3-Clause
// Pictures of cameras: read only while a client shows them, sent when the connection has room.
#include <algorithm>

#include "servers/viewer/foxglove_client.h"
#include "servers/viewer/page_client.h"
#include "servers/viewer/picture_message.h"
#include "servers/viewer/viewer.h"

namespace hrp {
namespace {

// Of a picture that cannot be shown, the message says why.
std::string make_message(const PictureKey& key, PictureSource* source, uint64_t number) {
  if (number == 0) return make_picture_message(key.source, key.topic, std::string("no picture at or before this time"));
  const PictureBytes sample = source->read(key.topic, number);
  if (!sample)
    return make_picture_message(key.source, key.topic, std::string("the picture cannot be read from the file"));
  try {
    const Bytes bytes{sample->data(), sample->size()};
    return make_picture_message(key.source, key.topic,
                                is_image(source->find_type(key.topic)) ? read_picture(bytes, kMostPagePixels)
                                                                       : read_scan(bytes, kMostPagePoints));
  } catch (const PictureError& error) {
    return make_picture_message(key.source, key.topic, std::string(error.what()));
  }
}

}  // namespace

PictureSource* Viewer::find_pictures(size_t source) const {
  if (live_) return source == 0 ? &live_->pictures() : nullptr;
  return source < recordings_.size() ? recordings_[source]->pictures() : nullptr;
}

// Only what somebody offers: a reader of another topic would wait for nothing.
void Viewer::read_pictures() {
  std::set<std::string> wanted;
  for (PageClient* page : pages_) wanted.insert(page->picture_topics().begin(), page->picture_topics().end());
  for (auto topic = wanted.begin(); topic != wanted.end();) {
    const auto offered = live_topics_.find(*topic);
    topic = offered != live_topics_.end() && is_picture(offered->second) ? std::next(topic) : wanted.erase(topic);
  }
  for (const auto& [topic, type] : live_topics_) {
    if (is_picture(type) && reads_foxglove(topic)) wanted.insert(topic);
  }
  live_->pictures().read_topics(wanted);
}

void Viewer::send_pictures() {
  for (PageClient* page : pages_) send_pictures(page);
  for (FoxgloveClient* client : foxgloves_) send_pictures(client);
  const auto is_shown = [this](const PictureKey& key) {
    return std::any_of(pages_.begin(), pages_.end(), [&](PageClient* page) { return page->pictures().shows(key); });
  };
  for (auto each = payloads_.begin(); each != payloads_.end();)
    each = is_shown(each->first) ? std::next(each) : payloads_.erase(each);
}

void Viewer::send_pictures(PageClient* page) {
  const auto now = Clock::now();
  for (const PictureKey& key : page->pictures().find_due(now)) {
    PictureSource* source = find_pictures(key.source);
    const double time = live_ || !source ? 0.0 : page->time_in(*recordings_[key.source]);
    const uint64_t number = source ? source->find(key.topic, time) : 0;
    const bool waits = live_ && number == 0;
    if (waits || page->pictures().has(key, number)) continue;
    if (page->connection().send(find_payload(key, number), true, Urgency::kPicture))
      page->pictures().note_sent(key, number, now);
  }
}

Payload Viewer::find_payload(const PictureKey& key, uint64_t number) {
  auto& [known, payload] = payloads_[key];
  if (!payload || known != number) payload = make_payload(make_message(key, find_pictures(key.source), number));
  known = number;
  return payload;
}

void Viewer::send_pictures(FoxgloveClient* client) {
  PictureSource* source = find_pictures(0);
  if (!source) return;
  const auto now = Clock::now();
  for (const PictureKey& key : client->pictures().find_due(now)) {
    const uint64_t number = source->find(key.topic, shown_time_);
    if (number == 0 || client->pictures().has(key, number)) continue;
    const PictureBytes sample = source->read(key.topic, number);
    if (!sample || client->send_picture(key.topic, {sample->data(), sample->size()}))
      client->pictures().note_sent(key, number, now);
  }
}

}  // namespace hrp
