// SPDX-License-Identifier: BSD-3-Clause
// Recordings of a standing robot: joints, one IMU, force sensors in the feet, perhaps the pose of the base. All signals
// are smoothed alike, so they stay comparable.
#pragma once

#include <string>
#include <vector>

#include "common/effects/joint_law.h"
#include "common/multibody/model.h"
#include "diagnosis/data/recording.h"
#include "diagnosis/data/smooth.h"

namespace hrp::diagnosis::standing {

// One recording, smoothed at its own stamps.
struct StandRecording {
  std::string file;
  bool train = true;
  std::vector<double> time;
  std::vector<int> grid;     // indices, one per smoothing window: nearly independent errors
  std::vector<int> samples;  // those of `grid` that are used
  int window = 1;            // samples between neighbours in `grid`
  int step = 1;              // the same between neighbours in `samples`, where none is left out
  // By joint; empty where not recorded. The second derivative of the effort comes from windows three times as wide.
  // Behind elastic transmissions it becomes an acceleration of the link, which its noise would otherwise dominate.
  std::vector<SmoothSeries> position, velocity, effort, command;
  std::vector<SmoothSeries> wrench;                     // by foot * 6: force x y z, torque x y z
  SmoothSeries gyro[3], accelerometer[3], attitude[4];  // attitude w x y z
  SmoothSeries base_position[3], base_attitude[4];      // [m], w x y z; empty where not recorded
};

// Contact surface of a foot. A flat sole determines the foot's tilt, a ball only its position.
enum class SoleKind { kFlat, kBall };

// A foot: its link, its force sensor, its contact surface and its bush.
struct StandFoot {
  std::string name, sensor;  // foot link; wrench sensor
  int link = -1;             // of the model, without mass there; the sensor is at its origin
  SoleKind kind = SoleKind::kFlat;
  double radius = 0;       // [m] of a ball
  Vector3d bush{0, 0, 0};  // [m] nominal centre of a bush in the foot link; a ball's centre
  Vector3d sole{0, 0, 0};  // [m] centre of the sole's lower face; `size`: its edges along x and y [m]
  Vector3d size{1e3, 1e3, 0};
  double mass = 0;  // [kg] of the foot; `com`: its centre of mass [m]
  Vector3d com{0, 0, 0};
};

// All inputs of the channels; constant.
struct StandProblem {
  const Experiment* experiment = nullptr;
  std::vector<StandRecording> recordings;
  std::vector<StandFoot> feet;
  std::string imu;
  int imu_link = -1;
  Matrix3d R_LI = Matrix3d::Identity();
  Vector3d p_LI = Vector3d::Zero();
  TreeSpec tree;                                // feet without mass: a sensor above a foot does not measure it
  std::vector<JointLaws> laws;                  // by joint, as the experiment states; empty: none
  std::vector<Vector3d> force_W;                // [N] by link, as the experiment states; empty: none
  std::vector<bool> effort, command, velocity;  // by joint: recorded in every recording
  std::vector<bool> law;      // by joint: the servo law gives the effort more precisely than its log (judge.h)
  bool attitude = true;       // recorded; if false, estimated (attitude.h)
  double attitude_error = 0;  // [rad] standard deviation of an estimated attitude
  bool base_pose = false;     // recorded
  bool held = false;          // a column repeats its values, so even and odd samples share noise
  // For loose transmissions: by joint the torque [N m] that exceeds noise; by channel the noise (channels.h).
  std::vector<double> slack, noise;
  bool is_driven(size_t joint) const { return effort[joint] || command[joint]; }
  bool has_law(size_t joint) const { return !effort[joint] || (joint < law.size() && law[joint]); }
};

// Samples that are smoothed (all, even, odd), and a factor on the width of the windows.
struct Smoothing {
  Parity parity = Parity::kAll;
  double wider = 1;
};

// Builds the problem. Returns false if the recordings lack something (feet with force sensors, an IMU, joint
// positions); `why` then says what.
bool make_stand_problem(const Experiment& experiment, Smoothing smoothing, StandProblem* problem, std::string* why);

}  // namespace hrp::diagnosis::standing
