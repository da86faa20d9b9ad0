// SPDX-License-Identifier: BSD-3-Clause
// An IMU against the encoders of legs that stand: what is left of its rates and of its vertical.
#pragma once

#include "diagnosis/floating/checks/standing_legs.h"
#include "diagnosis/floating/conventions/frame_search.h"

namespace hrp::diagnosis::floating {

// A sample of a clip.
struct Instant {
  const Clip* clip = nullptr;
  size_t k = 0;
};

// Legs that may stand, at a moment, and where the IMU is then: it turns by `more` than the base [rad/s].
struct Standing {
  Instant at;
  std::vector<StandingFeet> feet;
  Matrix3d R_BI;
  Vector3d more;
};

// Empty where the moments are too few, or legs tell nothing.
std::vector<Standing> list_standing(const LeggedLog& log, size_t imu, Purpose purpose);

std::vector<Instant> list_instants(const std::vector<Standing>& standing);

// What takes readings into the model's axes.
struct ImuAxes {
  Matrix3d gyro = Matrix3d::Identity(), accelerometer = Matrix3d::Identity();
};

// What an IMU is taken as.
struct Taken {
  ImuAxes axes;
  Clock clock;
  double per_unit = 1.0;  // what its accelerometer reads of 1 m/s^2
};

// [1] By moment, over what soles and encoders tell.
std::vector<double> list_left(const LeggedLog& log, size_t imu, const std::vector<Standing>& standing,
                              const Taken& taken);

// The mean before it is squared: feet that land or roll over an edge leave much, and tell nothing.
Left measure_over_legs(const LeggedLog& log, size_t imu, double per_unit, const std::vector<Standing>& standing);

// What is left by moment as one square, one of which is what soles and encoders tell.
double find_square(const std::vector<double>& left);

// [nats] Log odds that `a` leaves less than `b`, of which one is right; below zero: b. 0 where there is too little.
// Half a second is one observation of an error whose size is not known: its logarithm.
double calc_odds(const std::vector<Instant>& at, const std::vector<double>& left_a, const std::vector<double>& left_b);

}  // namespace hrp::diagnosis::floating
