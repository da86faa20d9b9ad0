// SPDX-License-Identifier: BSD-3-Clause
// How a standing robot moves at a sample of a recording, and what its force sensors feel, under a hypothesis.
#pragma once

#include "common/multibody/inverse_dynamics.h"
#include "diagnosis/standing/drive.h"
#include "diagnosis/standing/free_play.h"

namespace hrp::diagnosis::standing {

class StandMotion {
 public:
  // `offsets` [rad] by joint, by sample: where links lie between loose teeth; empty where they are not loose.
  StandMotion(const StandProblem& problem, const Hypothesis& hypothesis, size_t recording, TeethOffsets offsets);

 protected:
  // Everything below at the sample-th of the recording's samples.
  void read_motion(size_t sample);

  const StandProblem& p_;
  const StandRecording& r_;
  Terms terms_;
  Model model_;
  Data data_;
  State state_;
  LinkWrenches wrenches_;  // on the links: feet's sensors, forces from outside
  Eigen::VectorXd vdot_;
  Drives drives_;
  std::vector<DriveState> joints_;
  std::vector<Vector3d> force_, torque_;  // by foot, in the foot's axes
  Matrix3d R_WI_ = Matrix3d::Identity();
  Vector3d w_, dw_, f_;  // of the IMU in its axes: rate, its derivative, specific force
  bool known_ = true;    // false where a late sensor's reading, or that of a wrong clock, is not in the recording

 private:
  void read_imu(size_t k);
  void read_joints(size_t k, size_t sample);
  void find_base_motion();
  void read_wrenches(size_t k);
  double shifted(const SmoothSeries& s, bool rate, size_t k, double delay, double skew);

  TeethOffsets offsets_;
};

}  // namespace hrp::diagnosis::standing
