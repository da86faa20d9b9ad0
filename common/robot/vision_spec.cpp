// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/vision_spec.h"

#include <cmath>

namespace hrp {

Transform make_optical_frame() {
  Transform X_CO;
  X_CO.R << 0, 0, 1,  //
      -1, 0, 0,       //
      0, -1, 0;
  return X_CO;
}

std::string find_optical_frame_name(const CameraSpec& camera) { return camera.name + "_optical_frame"; }

std::string find_frame_name(const LidarSpec& lidar) { return lidar.name + "_frame"; }

bool is_look_due(double rate, uint64_t step, double time_step, int control_period) {
  const auto period = static_cast<uint64_t>(control_period);
  if (step % period != 0) return false;
  if (step == 0) return true;
  // [s] Times are multiples of the step, rounded: far less than a microsecond off.
  constexpr double kRounding = 1e-6;
  const auto count = [&](uint64_t k) { return std::floor((static_cast<double>(k) * time_step + kRounding) * rate); };
  return count(step) > count(step - period);
}

std::vector<size_t> find_looking_sensors(const std::vector<CameraSpec>& cameras, const std::vector<LidarSpec>& lidars,
                                         uint64_t step, double time_step, int control_period) {
  std::vector<size_t> found;
  if (step % static_cast<uint64_t>(control_period) != 0) return found;  // asked at every step
  const auto add = [&](size_t sensor, double rate) {
    if (is_look_due(rate, step, time_step, control_period)) found.push_back(sensor);
  };
  for (size_t i = 0; i < cameras.size(); ++i) add(i, cameras[i].rate);
  for (size_t i = 0; i < lidars.size(); ++i) add(cameras.size() + i, lidars[i].rate);
  return found;
}

}  // namespace hrp
