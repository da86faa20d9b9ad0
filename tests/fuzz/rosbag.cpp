// SPDX-License-Identifier: BSD-3-Clause
// Bags of ROS: files of sqlite3 (first byte 's') or of ROS 1 ('r'); or the definition of a type and a message of it,
// apart by a zero byte, as ROS 2 serializes (behind a byte '1': as ROS 1).
#include <cstring>
#include <stdexcept>

#include "common/log/ros_bag.h"
#include "common/log/ros_types.h"
#include "tests/fuzz/fuzz.h"

namespace {

using Open = std::unique_ptr<hrp::BagFile> (*)(const std::string&);

void read_storage(Open open, const uint8_t* data, size_t size) {
  const hrp::test::MemoryFile file(data, size);
  try {
    const std::unique_ptr<hrp::BagFile> bag = open(file.path());
    bag->read({}, [&](const hrp::BagMessage& message) {
      if (message.topic >= bag->topics().size()) std::abort();
    });
  } catch (const std::runtime_error&) {
  }
}

void read_message(const char* encoding, const std::string& definition, hrp::Bytes message) {
  try {
    const hrp::RosType type("sensor_msgs/msg/JointState", encoding, definition);
    hrp::RosValues values({"header.stamp.sec", "name", "position", "motor_state[].q"});
    values.read(type, message);
  } catch (const std::runtime_error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 1) return 0;
  if (data[0] == 's' || data[0] == 'r') {
    read_storage(data[0] == 's' ? hrp::open_sqlite_bag : hrp::open_ros1_bag, data + 1, size - 1);
    return 0;
  }
  const bool ros1 = data[0] == '1';
  if (ros1) {
    ++data;
    --size;
  }
  const void* zero = std::memchr(data, 0, size);
  if (zero == nullptr) return 0;
  const size_t length = static_cast<size_t>(static_cast<const uint8_t*>(zero) - data);
  read_message(ros1 ? "ros1msg" : "ros2msg", hrp::test::make_text(data, length),
               {data + length + 1, size - length - 1});
  return 0;
}
