// SPDX-License-Identifier: BSD-3-Clause
// Messages of ROS by the definitions that bags carry, or by those that are built in. Bytes are read by the one
// reflection of common/messages; here are only the types.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/base/ros_definitions.h"
#include "common/messages/reflection/sample.h"

namespace hrp {

// A type of ROS ("sensor_msgs/msg/JointState") with all that it needs.
class RosType {
 public:
  // `definition`: text of the bag in the format `encoding` ("ros2msg", "ros1msg"); empty or another format: the
  // built-in one of ROS 2. Throws std::runtime_error when the type is known by neither.
  RosType(const std::string& name, const std::string& encoding, const std::string& definition);
  const std::string& name() const { return name_; }
  const StructType& structure() const { return *structure_; }
  Wire wire() const { return wire_; }
  // Paths of all numbers and texts: "header.stamp.sec", "position" (a list), "motor_state[].q".
  bool has(const std::string& path) const;

 private:
  std::string name_;
  std::shared_ptr<const Schema> schema_;
  const StructType* structure_ = nullptr;
  Wire wire_ = Wire::kCdr;
};

// Values of one message at the paths that were asked for. Elements of lists, and of lists of structs, one after the
// other.
class RosValues {
 public:
  explicit RosValues(const std::vector<std::string>& paths);
  // Throws DecodeError when the bytes are no message of the type.
  void read(const RosType& type, Bytes message);
  const std::vector<double>& numbers(const std::string& path) const;
  const std::vector<std::string>& texts(const std::string& path) const;

 private:
  friend class PathVisitor;
  struct Slot {
    std::vector<double> numbers;
    std::vector<std::string> texts;
  };
  std::map<std::string, Slot> slots_;
};

}  // namespace hrp
