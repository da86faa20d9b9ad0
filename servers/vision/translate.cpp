// SPDX-License-Identifier: BSD-3-Clause
#include "servers/vision/translate.h"

#include <cmath>
#include <cstring>

#include "common/messages/ros_convert.h"

namespace hrp {
namespace {

constexpr uint8_t kFloat32 = 7;  // PointField's constant

// Numbers as they are in memory: all machines that this runs on are little endian, and say so in is_bigendian.
void set_bytes(const std::vector<float>& numbers, std::vector<uint8_t>* bytes) {
  bytes->resize(numbers.size() * sizeof(float));
  std::memcpy(bytes->data(), numbers.data(), bytes->size());
}

void set_image(const CameraSpec& camera, const char* encoding, size_t pixel_size, double time, RosImage* ros) {
  ros::set_time(time, &ros->header().stamp());
  ros->header().frame_id(find_optical_frame_name(camera));
  ros->height(static_cast<uint32_t>(camera.height));
  ros->width(static_cast<uint32_t>(camera.width));
  ros->encoding(encoding);
  ros->is_bigendian(0);
  ros->step(static_cast<uint32_t>(pixel_size) * ros->width());
}

}  // namespace

void set_camera_info(const CameraSpec& camera, double time, RosCameraInfo* ros) {
  const Pinhole pinhole = make_pinhole(camera);
  ros::set_time(time, &ros->header().stamp());
  ros->header().frame_id(find_optical_frame_name(camera));
  ros->height(static_cast<uint32_t>(camera.height));
  ros->width(static_cast<uint32_t>(camera.width));
  ros->distortion_model("plumb_bob");
  ros->d(std::vector<double>(5, 0.0));
  ros->k({pinhole.f, 0, pinhole.cx, 0, pinhole.f, pinhole.cy, 0, 0, 1});
  ros->r({1, 0, 0, 0, 1, 0, 0, 0, 1});
  ros->p({pinhole.f, 0, pinhole.cx, 0, 0, pinhole.f, pinhole.cy, 0, 0, 0, 1, 0});
}

void set_color_image(const CameraSpec& camera, const CameraPicture& picture, double time, RosImage* ros) {
  set_image(camera, "rgb8", 3, time, ros);
  ros->data() = picture.rgb;
}

void set_depth_image(const CameraSpec& camera, const CameraPicture& picture, double time, RosImage* ros) {
  set_image(camera, "32FC1", sizeof(float), time, ros);
  set_bytes(picture.depth, &ros->data());
}

void set_points(const LidarSpec& lidar, const Points& points, double time, RosPointCloud* ros) {
  ros::set_time(time, &ros->header().stamp());
  ros->header().frame_id(find_frame_name(lidar));
  ros->height(static_cast<uint32_t>(lidar.rows));
  ros->width(static_cast<uint32_t>(lidar.columns));
  ros->fields().resize(kNumbersPerPoint);
  const char* const names[kNumbersPerPoint] = {"x", "y", "z", "intensity"};
  for (size_t i = 0; i < kNumbersPerPoint; ++i) {
    ros->fields()[i].name(names[i]);
    ros->fields()[i].offset(static_cast<uint32_t>(i * sizeof(float)));
    ros->fields()[i].datatype(kFloat32);
    ros->fields()[i].count(1);
  }
  ros->is_bigendian(false);
  ros->point_step(static_cast<uint32_t>(kNumbersPerPoint * sizeof(float)));
  ros->row_step(ros->point_step() * ros->width());
  bool dense = true;
  for (const float number : points) dense = dense && !std::isnan(number);
  ros->is_dense(dense);
  set_bytes(points, &ros->data());
}

}  // namespace hrp
