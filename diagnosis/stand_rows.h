// SPDX-License-Identifier: BSD-3-Clause
// A standing robot on paper: what its joint efforts, foot wrenches, IMU and angles say about each other, sample by
// sample, without simulating. Base attitude and acceleration come from the IMU, foot wrenches from the force sensors.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "diagnosis/fit.h"

namespace hrp::diagnosis {

// One foot at one sample.
struct FootSample {
  Vector3d force = Vector3d::Zero(), torque = Vector3d::Zero();   // [N], [N m] as read, foot axes
  double roll = 0.0, pitch = 0.0;            // [rad] tilt of the sole against the horizontal
  Vector3d force_rate = Vector3d::Zero(), torque_rate = Vector3d::Zero();
  double height = 0.0;                       // [m] of the sole's centre above the base's origin (negative), world z
  Eigen::MatrixXd JT;                        // (6 + n) x 6: rows per wrench [moment; force] in foot axes about the foot's origin
};

struct StandSample {
  double time = 0.0;
  Eigen::VectorXd rows;                      // 6 + n: base wrench left over, then logged effort - needed effort
  std::vector<FootSample> feet;
  double base_z = 0.0;                       // [m] when recorded
  Eigen::VectorXd q, qd, qdd, effort, servo; // joints; servo: effort that it should have asked for
  Vector3d gyro_error = Vector3d::Zero();    // [rad/s] gyro minus rate of the attitude, sensor axes
};

struct StandSeries {
  std::vector<StandSample> samples;
  std::vector<std::string> foot_sensors;     // wrench sensor of each foot
  std::vector<std::string> foot_names;       // links as written
  std::vector<int> foot_links;
  std::vector<Vector3d> sole_centres;        // [m] link axes
  bool has_base_z = false;
};

// True when the recordings hold what this needs: IMU attitude, gyro and accelerometer, and a wrench at every foot.
bool can_stand_on_paper(const Experiment& e);

// What is tried out: effects on model and angles, and faults of the IMU.
struct StandChange {
  Hypothesis effects;
  Vector3d gyro_bias = Vector3d::Zero(), accelerometer_bias = Vector3d::Zero(), attitude_turn = Vector3d::Zero();
};

// Smooths a recording once and evaluates it under any change.
class StandRecording {
 public:
  StandRecording(const Problem& problem, int recording);
  ~StandRecording();
  StandRecording(StandRecording&&) noexcept;
  StandSeries evaluate(const StandChange& change) const;
  struct Smooth;

 private:
  const Problem* problem_;
  int recording_;
  std::unique_ptr<Smooth> smooth_;
};

}  // namespace hrp::diagnosis
