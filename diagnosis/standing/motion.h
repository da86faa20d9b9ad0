// SPDX-License-Identifier: BSD-3-Clause
// Motion of a standing robot at one sample of a recording, and its foot wrenches, under a hypothesis.
#pragma once

#include "common/multibody/inverse_dynamics.h"
#include "diagnosis/standing/drive.h"
#include "diagnosis/standing/free_play.h"

namespace hrp::diagnosis::standing {

// Base class of computations along a recording: sets the robot's state and wrenches at a sample.
class StandMotion {
 public:
  // `offsets` [rad]: by joint, by sample, the position of links in a gap; empty where a joint is not loose.
  StandMotion(const StandProblem& problem, const Hypothesis& hypothesis, size_t recording, PlayOffsets offsets);

 protected:
  // Computes all members below for a sample (index into the recording's samples).
  void read_motion(size_t sample);

  const StandProblem& p_;
  const StandRecording& r_;
  Terms terms_;
  Model model_;
  Data data_;
  State state_;
  LinkWrenches wrenches_;  // by link: foot sensors and external forces
  Eigen::VectorXd vdot_;
  Drives drives_;
  std::vector<DriveState> joints_;
  std::vector<Vector3d> force_, torque_;  // by foot, in the foot's axes
  Matrix3d R_WI_ = Matrix3d::Identity();
  Vector3d w_, dw_, f_;  // of the IMU in its axes: angular velocity, its derivative, specific force
  bool known_ = true;    // false if a delayed or skewed sensor reading is outside the recording

 private:
  void read_imu(size_t k);
  void read_joints(size_t k, size_t sample);
  void find_base_motion();
  void read_wrenches(size_t k);
  double shifted(const SmoothSeries& s, bool rate, size_t k, double delay, double skew);

  PlayOffsets offsets_;
};

}  // namespace hrp::diagnosis::standing
