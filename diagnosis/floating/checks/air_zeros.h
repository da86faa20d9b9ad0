// SPDX-License-Identifier: BSD-3-Clause
// Zeros of sensors that feel the vertical force alone: what they read while their foot is in the air. Sensors of three
// axes have equations that tell their zeros (equations/sensor_columns.cpp).
#pragma once

#include "diagnosis/findings/finding.h"
#include "diagnosis/floating/fit/columns.h"
#include "diagnosis/floating/log/contacts.h"

namespace hrp::diagnosis::floating {

struct AirZero {
  size_t sensor = 0, swings = 0;
  double value = 0, std = 0;  // [N] along the sensor's own z axis
};

// Zeros that are larger than a force sensor's are known to be.
std::vector<AirZero> find_air_zeros(const LeggedLog& log, const Contacts& contacts);

// The same by column, as correct_log() takes them.
Eigen::VectorXd list_zeros(const ColumnLayout& layout, const std::vector<AirZero>& zeros);

Finding make_zero_finding(const LeggedLog& log, const AirZero& zero);

}  // namespace hrp::diagnosis::floating
