// SPDX-License-Identifier: BSD-3-Clause
// A log with the types of its topics, as the log itself tells them.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "common/mcap/reader.h"
#include "common/messages/reflection/sample.h"

namespace hrp {

// One channel: topic, type, and the schema that the type belongs to.
struct LogTopicType {
  std::string topic;
  const StructType* type = nullptr;  // nullptr when the schema is not IDL that we can read
  bool stepped = false;              // begins with a msg::Header
  std::shared_ptr<Schema> schema;
};

class LogFile {
 public:
  // Throws mcap::McapError.
  explicit LogFile(const std::string& path);
  mcap::Reader& reader() { return reader_; }
  const std::map<uint16_t, LogTopicType>& topics() const { return topics_; }
  // "robot_state" and "/hrp/robot_state" mean "hrp/robot_state". Throws InputError naming the nearest topic.
  const LogTopicType& find_topic(const std::string& name) const;

 private:
  mcap::Reader reader_;
  std::map<uint16_t, LogTopicType> topics_;  // by channel
};

// Names damage on the error output. Returns the exit status: 0 where there is none, else 1.
int say_damage(const mcap::Reader& reader);

inline Bytes get_bytes(const mcap::Message& message) { return {message.data, message.size}; }

}  // namespace hrp
