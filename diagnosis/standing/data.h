// SPDX-License-Identifier: BSD-3-Clause
// Recordings of a standing robot: joints, one IMU, force sensors in the feet, perhaps a pose of the base, smoothed
// alike so that they stay comparable.
#pragma once

#include <string>
#include <vector>

#include "common/multibody/model.h"
#include "common/effects/joint_law.h"
#include "diagnosis/data/recording.h"
#include "diagnosis/data/smooth.h"

namespace hrp::diagnosis::standing {

struct StandRecording {
  std::string file;
  bool train = true;
  std::vector<double> time;
  std::vector<int> grid;     // one sample a smoothing window: nearly independent errors
  std::vector<int> samples;  // those of them that are kept
  int window = 1;            // stamps from one of the grid to the next
  int step = 1;              // the same of the kept ones, where none is left out
  // By joint; empty where not recorded. An effort's second derivative stems from windows three times as wide: it turns
  // into accelerations of links behind elastic transmissions, where its noise would hide everything.
  std::vector<SmoothSeries> position, velocity, effort, command;
  std::vector<SmoothSeries> wrench;                     // by foot * 6: force x y z, torque x y z
  SmoothSeries gyro[3], accelerometer[3], attitude[4];  // attitude w x y z
  SmoothSeries base_position[3], base_attitude[4];      // [m], w x y z; empty where not recorded
};

// What of a foot touches the ground: a flat sole tells its tilt, a ball only where it is.
enum class SoleKind { kFlat, kBall };

struct StandFoot {
  std::string name, sensor;  // foot link; wrench sensor
  int link = -1;             // of the model, massless there: the sensor sits at its origin
  SoleKind kind = SoleKind::kFlat;
  double radius = 0;       // [m] of a ball
  Vector3d bush{0, 0, 0};  // [m] nominal centre of a bush in the foot link; a ball's centre
  Vector3d sole{0, 0, 0};  // [m] centre of the sole's lower face; edges of it along x and y in `size`
  Vector3d size{1e3, 1e3, 0};
  double mass = 0;  // [kg] of the foot, and where [m]
  Vector3d com{0, 0, 0};
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
  TreeSpec tree;                                // feet without mass: what is below a sensor is not felt above it
  std::vector<JointLaws> laws;                  // by joint, as stated; empty: none
  std::vector<Vector3d> force_W;                // [N] by link, as stated; empty: none
  std::vector<bool> effort, command, velocity;  // by joint: recorded in every recording
  std::vector<bool> law;      // by joint: the servo law tells the effort better than its log (choose_laws() of judge.h)
  bool attitude = true;       // recorded, else found from the base pose, or from gyroscope and accelerometer
  double attitude_error = 0;  // [rad] standard deviation of an attitude that had to be found
  bool base_pose = false;     // recorded
  bool held = false;          // some column repeats its values: even and odd samples share their noise
  // For loose transmissions: a torque [N m] by joint that is no noise, and the noise of each channel (channels.h).
  std::vector<double> slack, noise;
  bool is_driven(size_t joint) const { return effort[joint] || command[joint]; }
  bool has_law(size_t joint) const { return !effort[joint] || (joint < law.size() && law[joint]); }
};

// Which samples a recording is smoothed from, and in windows how much wider than usual.
struct Smoothing {
  Parity parity = Parity::kAll;
  double wider = 1;
};

// False when the recordings lack what this needs: feet with force sensors and an IMU. `why` says what.
bool make_stand_problem(const Experiment& experiment, Smoothing smoothing, StandProblem* problem, std::string* why);

}  // namespace hrp::diagnosis::standing
