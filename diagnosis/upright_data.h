// SPDX-License-Identifier: BSD-3-Clause
// Recordings of a standing robot: joints, one IMU, force sensors in the feet, smoothed alike so that they stay
// comparable, and the effects that a hypothesis may add.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/multibody/model.h"
#include "diagnosis/recording.h"

namespace hrp::diagnosis::upright {

// A smoothed series at the recording's stamps, with its rate.
struct Series {
  std::vector<double> value, rate, second;
};

struct StandRecording {
  std::string file;
  bool train = true;
  std::vector<double> time;
  std::vector<int> samples;                      // kept: one a smoothing window, so that errors are about independent
  std::vector<Series> position, effort, command; // by joint
  std::vector<Series> wrench;                    // by foot * 6: force x y z, torque x y z
  Series gyro[3], accelerometer[3], attitude[4]; // attitude w x y z
};

struct StandFoot {
  std::string name, sensor;  // foot link; wrench sensor
  int link = -1;             // of the model, massless there: the sensor sits at its origin
  Vector3d bush{0, 0, 0};    // [m] nominal centre of a bush in the foot link
  Vector3d sole{0, 0, 0};    // [m] centre of the sole's lower face; edges of it along x and y in `size`
  Vector3d size{1e3, 1e3, 0};
};

// Everything the channels are computed from; constant.
struct StandProblem {
  const Experiment* experiment = nullptr;
  std::vector<StandRecording> recordings;
  std::vector<StandFoot> feet;
  std::string imu;
  int imu_link = -1;
  Matrix3d R_LI = Matrix3d::Identity();
  Vector3d p_LI = Vector3d::Zero();
  TreeSpec tree;               // feet without mass: what is below a sensor is not felt above it
  std::vector<bool> driven;    // joints with effort and command
  bool has_effort = false, has_command = false;
};

// False when the recordings lack what this needs: feet with force sensors and an IMU. `why` says what.
bool make_stand_problem(const Experiment& experiment, StandProblem* problem, std::string* why);

}  // namespace hrp::diagnosis::upright
