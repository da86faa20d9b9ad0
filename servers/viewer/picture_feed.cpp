// SPDX-License-Identifier: BSD-3-Clause
#include "servers/viewer/picture_feed.h"

#include <algorithm>

namespace hrp {
namespace {

constexpr auto kPicturePeriod = std::chrono::milliseconds(100);

}  // namespace

void PictureFeed::show(const std::set<PictureKey>& keys) {
  std::map<PictureKey, Sent> shown;
  for (const PictureKey& key : keys) shown[key] = sent_[key];
  sent_ = std::move(shown);
}

void PictureFeed::forget() {
  for (auto& [key, sent] : sent_) sent = {};
}

std::vector<PictureKey> PictureFeed::find_due(Clock::time_point now) const {
  std::vector<std::pair<Clock::time_point, PictureKey>> due;
  for (const auto& [key, sent] : sent_) {
    if (!sent.number || now - sent.when >= kPicturePeriod) due.emplace_back(sent.when, key);
  }
  std::sort(due.begin(), due.end());
  std::vector<PictureKey> keys;
  for (auto& [when, key] : due) keys.push_back(std::move(key));
  return keys;
}

bool PictureFeed::has(const PictureKey& key, uint64_t number) const {
  const auto found = sent_.find(key);
  return found != sent_.end() && found->second.number == number;
}

void PictureFeed::note_sent(const PictureKey& key, uint64_t number, Clock::time_point now) {
  const auto found = sent_.find(key);
  if (found != sent_.end()) found->second = {number, now};
}

}  // namespace hrp
