// SPDX-License-Identifier: BSD-3-Clause
// Which columns of other people's logs are of an inertial sensor: "imu_gyro_x", "base_ang_vel_z", "AccY", "quat_w".
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace hrp::diagnosis {

struct ImuColumn {
  size_t column = 0;
  std::string signal;  // "angular_velocity/x", "linear_acceleration/z", "orientation/w"
};

// Of one sensor: the first columns that have all axes of a quantity. Empty: neither rates nor accelerations.
std::vector<ImuColumn> find_imu_columns(const std::vector<std::string>& columns);

}  // namespace hrp::diagnosis
