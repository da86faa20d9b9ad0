// SPDX-License-Identifier: BSD-3-Clause
// The pictures of a log. Only where they stand is kept in memory; each is read from the file when somebody looks at it.
#pragma once

#include <map>

#include "common/mcap/reader.h"
#include "servers/viewer/picture_source.h"

namespace hrp {

class PictureLog final : public PictureSource {
 public:
  explicit PictureLog(std::shared_ptr<mcap::Reader> reader) : reader_(std::move(reader)) {}
  // Building: channels that hold pictures, then every message of theirs in the order of the file.
  void add_topic(uint16_t channel, const std::string& topic, const std::string& type);
  void add(const mcap::Message& message);

  // Topic -> type.
  std::map<std::string, std::string> topics() const;
  std::string find_type(const std::string& topic) const override;
  // The last picture that is not after `time`.
  uint64_t find(const std::string& topic, double time) const override;
  PictureBytes read(const std::string& topic, uint64_t number) override;

 private:
  struct Place {
    uint64_t log_time = 0;  // [ns]
    size_t chunk = 0;       // of the file
    size_t index = 0;       // within the chunk, of the messages of its channel
  };
  struct Topic {
    uint16_t channel = 0;
    std::string type;
    std::vector<Place> places;  // by time
  };
  std::shared_ptr<mcap::Reader> reader_;
  std::map<std::string, Topic> topics_;
  std::map<uint16_t, std::string> names_;  // by channel
};

}  // namespace hrp
