// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/vision_section.h"

#include <cctype>
#include <cmath>

#include "common/base/format.h"

namespace hrp {
namespace {

// A picture beyond this takes seconds; a message of it has 200 MB.
constexpr unsigned long long kMostPixels = 4096, kMostRays = 1000000;
constexpr double kLeastFov = 0.01, kMostFov = 3.0;  // [rad] beyond, a plane of pixels is no camera

// It becomes a part of topic names.
void check_name(YamlMap& map, const std::string& name) {
  bool good = !name.empty() && std::isdigit(static_cast<unsigned char>(name[0])) == 0;
  for (const char c : name) good = good && (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_');
  if (!good) map.error("", "is the name of topics, expected letters, digits and _, and no digit first");
}

void read_count(YamlMap& map, const std::string& key, int* count, unsigned long long most) {
  unsigned long long number = static_cast<unsigned long long>(*count);
  map.integer(key, &number);
  if (number < 1 || number > most) {
    map.error(key, "is " + std::to_string(number) + ", expected 1 to " + std::to_string(most));
    return;
  }
  *count = static_cast<int>(number);
}

void read_mount(YamlMap& map, std::string* link, Transform* X_LC) {
  map.text("link", link);
  Vector3d rpy = Vector3d::Zero();
  map.vector3("xyz", &X_LC->p, Bound::kAny, "m");
  map.vector3("rpy", &rpy, Bound::kAny, "rad");
  X_LC->R = make_rotation_from_rpy(rpy);
}

void read_camera(YamlMap& map, CameraSpec* camera) {
  check_name(map, camera->name);
  read_mount(map, &camera->link, &camera->X_LC);
  read_count(map, "width", &camera->width, kMostPixels);
  read_count(map, "height", &camera->height, kMostPixels);
  map.number("fov", &camera->fov, Bound::kPositive, "rad");
  if (camera->fov < kLeastFov || camera->fov > kMostFov) {
    map.error("fov", "is " + format("%g", camera->fov) + " rad, expected " + format("%g", kLeastFov) + " to " +
                         format("%g", kMostFov) + " rad");
  }
  map.number("rate", &camera->rate, Bound::kPositive, "1/s");
  map.number("near", &camera->near, Bound::kPositive, "m");
  map.number("far", &camera->far, Bound::kPositive, "m");
  if (camera->far <= camera->near)
    map.error("far",
              "is " + format("%g", camera->far) + " m, expected more than near, " + format("%g", camera->near) + " m");
  map.flag("color", &camera->color);
  map.flag("depth", &camera->depth);
  if (!camera->color && !camera->depth) map.error("", "takes neither color nor depth: expected one of them");
  map.number("color_noise", &camera->color_noise, Bound::kNotNegative, "");
  map.number("depth_noise", &camera->depth_noise, Bound::kNotNegative, "m");
}

void read_lidar(YamlMap& map, LidarSpec* lidar) {
  check_name(map, lidar->name);
  read_mount(map, &lidar->link, &lidar->X_LC);
  map.number("rate", &lidar->rate, Bound::kPositive, "1/s");
  read_count(map, "columns", &lidar->columns, kMostRays);
  read_count(map, "rows", &lidar->rows, kMostRays / static_cast<unsigned long long>(lidar->columns));
  map.interval("azimuth", &lidar->first_azimuth, &lidar->last_azimuth, Bound::kAny, "rad");
  if (lidar->last_azimuth - lidar->first_azimuth > 2 * M_PI + 1e-3)
    map.error("azimuth", "is more than a turn; are these degrees?");
  map.interval("elevation", &lidar->first_elevation, &lidar->last_elevation, Bound::kAny, "rad");
  if (std::max(-lidar->first_elevation, lidar->last_elevation) > 0.5 * M_PI + 1e-3) {
    map.error("elevation", "is beyond a right angle; are these degrees?");
  }
  map.interval("range", &lidar->min_range, &lidar->max_range, Bound::kNotNegative, "m");
  map.number("noise", &lidar->noise, Bound::kNotNegative, "m");
}

}  // namespace

void read_vision_sensors(YamlMap& map, SensorsSpec* sensors) {
  map.named("camera", &sensors->cameras, read_camera);
  map.named("lidar", &sensors->lidars, read_lidar);
  map.flag("every_picture", &sensors->every_picture);
}

void check_look_rates(const Scenario& scenario, Diagnostics* diagnostics) {
  const double most = 1.0 / (scenario.time_step * scenario.control_period);
  const auto check = [&](const std::string& sensor, double rate) {
    if (rate <= most * (1.0 + 1e-9)) return;  // periods are decimal numbers that binary ones only approximate
    diagnostics->add_error(
        scenario.make_diagnostic(sensor + ".rate", "is " + format("%g", rate) + " 1/s, expected at most " +
                                                       format("%g", most) + " 1/s: once in a control period"));
  };
  for (const CameraSpec& camera : scenario.sensors.cameras) check("sensors.camera." + camera.name, camera.rate);
  for (const LidarSpec& lidar : scenario.sensors.lidars) check("sensors.lidar." + lidar.name, lidar.rate);
}

}  // namespace hrp
