// SPDX-License-Identifier: BSD-3-Clause
#include "servers/viewer/picture_source.h"

#include "common/base/ros_definitions.h"
#include "common/messages/ros_topics.h"

namespace hrp {

bool is_image(const std::string& type) { return find_ros_name(type) == "sensor_msgs/msg/Image"; }

bool is_picture(const std::string& type) {
  return is_image(type) || find_ros_name(type) == "sensor_msgs/msg/PointCloud2";
}

bool is_of_camera(const std::string& type) {
  return is_picture(type) || find_ros_name(type) == "sensor_msgs/msg/CameraInfo";
}

bool is_picture_topic(const std::string& topic) {
  const TopicSpec* known = topics::find_any_topic(topic);
  return known && is_picture(known->type_name);
}

}  // namespace hrp
