// SPDX-License-Identifier: BSD-3-Clause
// An IMU that is mounted some degrees otherwise than the model says, and a gyroscope with another scale: told by what
// turns with the body, not by forces, before forces are asked.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "diagnosis/findings/finding.h"
#include "diagnosis/floating/checks/gyro_map.h"
#include "diagnosis/floating/fit/columns.h"

namespace hrp::diagnosis::floating {

// What is turned with the gyroscope's axes. kUnknown: up is where it was by both.
enum class Turned { kGyroscope, kWhole, kUnknown };

struct ImuFault {
  size_t imu = 0;
  GyroMap map;
  Turned what = Turned::kGyroscope;
  bool by_pose = false;      // the base's pose tells, else legs that stand
  bool pose_may_be = false;  // the pose may be turned in its place: legs do not tell
};

std::vector<ImuFault> find_imu_faults(const LeggedLog& log);

// How gyroscopes agree with encoders of legs that stand, where no pose tells it: sentences.
std::vector<std::string> compare_gyros(const LeggedLog& log);

// By column.
Eigen::VectorXd list_imu_faults(const ColumnLayout& layout, const std::vector<ImuFault>& faults);

void add_imu_findings(const LeggedLog& log, const ImuFault& fault, std::vector<Finding>* out);

}  // namespace hrp::diagnosis::floating
