// SPDX-License-Identifier: BSD-3-Clause
// Bags of ROS 2: files of sqlite3 (first byte 's'), or the definition of a type and a message of it, apart by a zero byte.
#include <cstring>
#include <stdexcept>

#include "common/log/ros_bag.h"
#include "common/log/ros_types.h"
#include "tests/fuzz/fuzz.h"

namespace {

void read_storage(const uint8_t* data, size_t size) {
  const hrp::test::MemoryFile file(data, size);
  try {
    const std::unique_ptr<hrp::BagFile> bag = hrp::open_sqlite_bag(file.path());
    bag->read({}, [&](const hrp::BagMessage& message) {
      if (message.topic >= bag->topics().size()) std::abort();
    });
  } catch (const std::runtime_error&) {
  }
}

void read_message(const std::string& definition, hrp::Bytes message) {
  try {
    const hrp::RosType type("sensor_msgs/msg/JointState", "ros2msg", definition);
    hrp::RosValues values({"header.stamp.sec", "name", "position", "motor_state[].q"});
    values.read(type, message);
  } catch (const std::runtime_error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 1) return 0;
  if (data[0] == 's') {
    read_storage(data + 1, size - 1);
    return 0;
  }
  const void* zero = std::memchr(data, 0, size);
  if (zero == nullptr) return 0;
  const size_t length = static_cast<size_t>(static_cast<const uint8_t*>(zero) - data);
  read_message(hrp::test::make_text(data, length), {data + length + 1, size - length - 1});
  return 0;
}
