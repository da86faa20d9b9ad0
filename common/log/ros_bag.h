// SPDX-License-Identifier: BSD-3-Clause
// Bags of ROS. ROS 2 (rosbag2): a folder with metadata.yaml and its files, or one file. Storage MCAP or sqlite3;
// chunks, messages or whole files may be compressed. ROS 1: one file.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "common/bus/bus.h"

namespace hrp {

struct BagTopic {
  std::string name;      // "/joint_states"
  std::string type;      // "sensor_msgs/msg/JointState"
  std::string encoding;  // of the definition: "ros2msg", "ros2idl", "ros1msg"; empty: the bag has none
  std::string definition;
  uint64_t count = 0;  // messages; 0: not known before they are read
};

struct BagMessage {
  size_t topic = 0;      // in RosBag::topics()
  int64_t received = 0;  // [ns] clock of the recorder
  Bytes data;            // valid during the call
};

// One file of a bag.
class BagFile {
 public:
  virtual ~BagFile() = default;
  virtual const std::vector<BagTopic>& topics() const = 0;
  // In the order of the file.
  virtual void read(const std::set<std::string>& topics, const std::function<void(const BagMessage&)>& visit) = 0;
  virtual std::string damage() const { return ""; }
};

class RosBag {
 public:
  // `path`: folder, metadata.yaml, or one file (.bag; .mcap, .db3, either with .zstd behind). Throws InputError naming
  // the file.
  explicit RosBag(const std::string& path);
  const std::string& path() const { return path_; }
  const std::vector<BagTopic>& topics() const { return topics_; }
  // Messages of the topics of these names, file by file. Returns what is wrong with the files; empty: nothing.
  std::string read(const std::set<std::string>& topics, const std::function<void(const BagMessage&)>& visit) const;

 private:
  std::string path_;
  std::vector<std::string> files_;
  std::string message_compression_;  // "zstd" when every message is compressed by itself
  std::vector<BagTopic> topics_;
};

// Whether a recording is a bag: a folder, or a file with such an ending that is no log of ours.
bool is_ros_bag(const std::string& path);

// sqlite3; in ros_bag_sqlite.cpp. Throws std::runtime_error.
std::unique_ptr<BagFile> open_sqlite_bag(const std::string& path);
// ROS 1; in ros1_bag.cpp. Throws std::runtime_error.
std::unique_ptr<BagFile> open_ros1_bag(const std::string& path);

}  // namespace hrp
