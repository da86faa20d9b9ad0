// SPDX-License-Identifier: BSD-3-Clause
// Definitions of the messages of ROS 2 that this project reads or writes: field for field those of Humble to Jazzy.
#pragma once

#include <string>
#include <vector>

namespace hrp {

// One line of a definition: "float64[9] covariance".
struct RosField {
  std::string type;  // as it stands there, brackets included
  std::string name;
  std::string base;  // "float64", or the full name of a message: "std_msgs/msg/Header"
  bool is_message = false;
  bool is_sequence = false;
  size_t array_size = 0;  // 0: no array
};

// Lines of a type by its full name ("sensor_msgs/msg/JointState"); nullptr when it is none of ours.
const char* find_ros_definition(const std::string& name);
// Throws std::runtime_error for a type that is none of ours.
std::vector<RosField> parse_ros_definition(const std::string& name);
// As bags carry it (`ros2msg`): the type's lines, then those of each type that it needs behind "MSG: package/Type".
std::string make_ros_schema(const std::string& name);
// "RIHS01_" and 64 hexadecimal digits: REP 2011, the hash of the type's description.
std::string calc_ros_type_hash(const std::string& name);

// What rmw says of an end in its USER_DATA: "typehash=RIHS01_...;". Empty for types that are none of ROS 2.
std::string make_ros_user_data(const std::string& dds_type_name);

// "sensor_msgs/JointState" and "sensor_msgs::msg::dds_::JointState_" -> "sensor_msgs/msg/JointState".
std::string find_ros_name(const std::string& name);

}  // namespace hrp
