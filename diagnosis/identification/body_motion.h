// SPDX-License-Identifier: BSD-3-Clause
// One motion as the equations of motion need it [M14 eq. 1]: what moves, and what the ankles exert on the robot above
// them.
//
// The force sensors are in the ankles, so the feet below them are no part of the robot that is identified, and no
// contact is.
#pragma once

#include "common/multibody/kinematics.h"
#include "common/multibody/regressor.h"
#include "diagnosis/identification/bush_angles.h"

namespace hrp::identification {

// The robot as its URDF describes it, with rigid feet.
struct BodyRig {
  explicit BodyRig(const Scenario& scenario);
  RobotDescription robot;
  Model model;
  int imu_link = 0;
  Transform X_LI;
  std::vector<int> feet;  // links
  bool is_foot(int link) const;
};

// Smoothed by one kernel and thinned. The base is link 0; W is level and turns only as slowly as a gyroscope drifts.
struct BodyMotion {
  std::string name;
  double period = 0.0;  // [s]
  std::vector<Matrix3d> R_WB;
  Samples w, vdot;        // [rad/s] of the base, W; [alpha_W; a_W of the base's origin; qdd]
  Samples q, qd, effort;  // joints of the model; effort is empty when it was not recorded
  Samples direction;      // sign of qd, through the same filter: +-1 where the joint has not turned round lately
  Samples exerted;        // J^T F of what the ankles exert: [moment about the base's origin; force; by joint]
  // What an error of the force sensors' zeros, foot by foot [N; N m], does to the first six rows of `exerted`; mean.
  Eigen::Matrix<double, 6, Eigen::Dynamic> zero_gain;
  std::vector<bool> measured;  // by joint: has an encoder
  Eigen::Index size() const { return q.cols(); }
};
BodyMotion observe_body(const BodyRig& rig, const BushObserver& observer, const RobotLog& log,
                        const std::vector<SensorZero>& zeros);

// Regressor of one sample, left-hand sides of [M14 eq. 1] beside it: base (6), joints.
class BodyEquations {
 public:
  explicit BodyEquations(const BodyRig& rig);
  void update(const BodyMotion& motion, Eigen::Index k);
  const Regressor& Y() const { return Y_; }

 private:
  const BodyRig& rig_;
  Data data_;
  State state_;
  Regressor Y_;
};

}  // namespace hrp::identification
