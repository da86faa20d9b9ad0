// SPDX-License-Identifier: BSD-3-Clause
// Equations of IMUs: against the base's recorded pose, against the main IMU through the encoders, and at rest.
#pragma once

#include "diagnosis/floating/fit/columns.h"
#include "diagnosis/floating/fit/row_table.h"
#include "diagnosis/floating/log/contacts.h"

namespace hrp::diagnosis::floating {

class ImuRows {
 public:
  ImuRows(const LeggedLog& log, const Contacts& contacts, const ColumnLayout& layout, RowTable* table);
  // Adds the rows of sample k, at which `motion` stands.
  void add(size_t clip, size_t k, BodyMotion* motion);

 private:
  struct Channels {
    int gyro[3] = {-1, -1, -1}, accelerometer[3] = {-1, -1, -1}, gravity = -1, level[3] = {-1, -1, -1};
    bool over_feet = false;  // nothing else tells the gyroscope's rate
  };
  std::vector<int> list_over_feet(size_t imu) const;
  void add_gyro(size_t imu, const Clip& clip, size_t k, BodyMotion* motion);
  void add_gyro_over_feet(size_t imu, size_t clip, size_t k, BodyMotion* motion);
  void add_accelerometer(size_t imu, const Clip& clip, size_t k, BodyMotion* motion);
  void add_gravity(size_t imu, size_t clip, size_t k, BodyMotion* motion);
  void put(const int* channels, int scale_column, int imu, const Vector3d& reading, const Vector3d& rate,
           const Vector3d& expected);

  const LeggedLog& log_;
  const Contacts& contacts_;
  const ColumnLayout& layout_;
  RowTable& table_;
  int main_ = -1;
  std::vector<Channels> channels_;
};

}  // namespace hrp::diagnosis::floating
