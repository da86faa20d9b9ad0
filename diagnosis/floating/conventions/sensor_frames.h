// SPDX-License-Identifier: BSD-3-Clause
// Sensors of a body that are mounted a quarter or half turn otherwise than the model says, and sensors whose clock is
// far from that of the encoders. Small turns and delays are effects like others; these are too large for anything
// linear.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/data/recording.h"
#include "diagnosis/floating/log/legged_log.h"

namespace hrp::diagnosis::floating {

struct SensorFrame {
  std::string sensor;                 // "/imu/waist", "/wrench/l_foot"; "/imu/waist/angular_velocity": that half alone
  Matrix3d R = Matrix3d::Identity();  // it reads R^T v in the place of v; of a half it may be left-handed
  double late = 0.0;                  // [s] its stamps are behind those of the encoders by so much
  double left = 1.0;                  // share of the error, in squares, that is left without both
  std::string rival;                  // a sensor that may be off in the place of this one; empty: none
  bool is_turned() const { return !R.isIdentity(1e-9); }
};

// Why an accelerometer sees the vertical upside down: it is turned with its gyroscope, as a turned IMU turns its rates
// as well, or it counts gravity the other way. `per_unit`: what it reads of 1 m/s^2.
enum class Upside { kTurned, kCounts, kUnknown };
Upside find_upside(const LeggedLog& log, size_t imu, double per_unit);

// Of a floating base whose recordings tell. What is expected of an IMU comes from the base's pose, else from feet that
// stand; of force sensors, from the balance of the whole body. An IMU that agrees with legs that stand is not off.
std::vector<SensorFrame> find_sensor_frames(const Experiment& experiment);

// Clocks and mountings that recordings are too short to tell, with the reason.
std::vector<std::string> list_not_looked_for(const Experiment& experiment);

// The same experiment with readings in the model's axes and at the encoders' time.
Experiment convert_sensor_frames(Experiment experiment, const std::vector<SensorFrame>& frames);

}  // namespace hrp::diagnosis::floating
