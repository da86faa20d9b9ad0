// SPDX-License-Identifier: BSD-3-Clause
// The newest picture of each topic of a live run that somebody looks at. Readers are best-effort, so no writer waits.
#pragma once

#include <map>
#include <set>

#include "common/bus/bus.h"
#include "servers/viewer/picture_source.h"

namespace hrp {

class LivePictures final : public PictureSource {
 public:
  explicit LivePictures(Bus& bus) : bus_(bus) {}
  // Which topics to read from now on. Not under the bus's mutex.
  void read_topics(const std::set<std::string>& topics);
  std::string find_type(const std::string& topic) const override;
  uint64_t find(const std::string& topic, double time) const override;
  PictureBytes read(const std::string& topic, uint64_t number) override;

 private:
  struct Topic {
    uint64_t number = 0;  // of the newest picture, 0: none came yet
    PictureBytes newest;
    std::unique_ptr<Reader> reader;  // ends first
  };
  Bus& bus_;
  uint64_t count_ = 0;  // pictures that came, of all topics
  std::map<std::string, std::unique_ptr<Topic>> topics_;
};

}  // namespace hrp
