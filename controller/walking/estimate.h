// SPDX-License-Identifier: BSD-3-Clause
// What sensors say about balance: pure functions.
#pragma once

#include "common/robot/signals.h"
#include "controller/walking/lipm.h"

namespace hrp::walking {

// Wrench of the ground on a foot, axes of the sole, moment about the middle of the sole.
struct FootLoad {
  Vector3d force = Vector3d::Zero();   // [N]
  Vector3d torque = Vector3d::Zero();  // [N m]
};

// From a force sensor whose frame F has the sole at X_FS.
FootLoad calc_foot_load(const WrenchSample& wrench, const Transform& X_FS);

// Zero moment point of a foot on its sole: x = -tau_y / f_z, y = tau_x / f_z. Zero when f_z <= least [N].
Vector2d calc_foot_zmp(const FootLoad& load, double least);

// Of both feet, in the axes of `soles`, weighted by f_z. False when the feet carry less than `least` [N] together.
bool calc_zmp(const FootLoad loads[2], const Transform soles[2], double least, Vector3d* zmp);

// Attitude from gyro and accelerometer alone: integration, drawn towards the direction of gravity with a time constant
// [s] that must be long against a step (Mahony's filter without bias). Heading is that of the start.
class AttitudeFilter {
 public:
  explicit AttitudeFilter(double time_constant = 5.0) : time_constant_(time_constant) {}
  void reset(const Matrix3d& R_WS) { R_ = Eigen::Quaterniond(R_WS); }
  void update(const Vector3d& gyro_S, const Vector3d& acceleration_S, double dt);
  Matrix3d get() const { return R_.toRotationMatrix(); }

 private:
  double time_constant_;
  Eigen::Quaterniond R_ = Eigen::Quaterniond::Identity();
};

// Level attitude (roll, pitch; heading zero) that explains an accelerometer at rest.
Matrix3d calc_level_attitude(const Vector3d& acceleration_S);

}  // namespace hrp::walking
