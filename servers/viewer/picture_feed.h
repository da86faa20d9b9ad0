// SPDX-License-Identifier: BSD-3-Clause
// What one client is shown of cameras: of each the newest picture, none twice, at most ten a second.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace hrp {

struct PictureKey {
  size_t source = 0;  // recording; a live run is source 0
  std::string topic;
  bool operator<(const PictureKey& other) const {
    return source != other.source ? source < other.source : topic < other.topic;
  }
};

class PictureFeed {
 public:
  using Clock = std::chrono::steady_clock;
  // From now on these. What was sent of those that stay is remembered, so it does not come twice.
  void show(const std::set<PictureKey>& keys);
  // Everything is sent again.
  void forget();
  bool shows(const PictureKey& key) const { return sent_.count(key) > 0; }
  // Those that may have another picture now, the one that has waited longest first: on a slow connection each has its
  // turn.
  std::vector<PictureKey> find_due(Clock::time_point now) const;
  bool has(const PictureKey& key, uint64_t number) const;
  void note_sent(const PictureKey& key, uint64_t number, Clock::time_point now);

 private:
  struct Sent {
    std::optional<uint64_t> number;
    Clock::time_point when{};
  };
  std::map<PictureKey, Sent> sent_;
};

}  // namespace hrp
