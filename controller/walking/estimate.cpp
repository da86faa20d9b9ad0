// SPDX-License-Identifier: BSD-3-Clause
#include "controller/walking/estimate.h"

#include <cmath>

namespace hrp::walking {

FootLoad calc_foot_load(const WrenchSample& wrench, const Transform& X_FS) {
  FootLoad load;
  load.force = X_FS.R.transpose() * wrench.force;
  load.torque = X_FS.R.transpose() * (wrench.torque - X_FS.p.cross(wrench.force));
  return load;
}

Vector2d calc_foot_zmp(const FootLoad& load, double least) {
  if (!(load.force.z() > least)) return Vector2d::Zero();
  return Vector2d(-load.torque.y(), load.torque.x()) / load.force.z();
}

bool calc_zmp(const FootLoad loads[2], const Transform soles[2], double least, Vector3d* zmp) {
  Vector3d sum = Vector3d::Zero();
  double total = 0.0;
  for (int side = 0; side < 2; ++side) {
    const double f = std::max(0.0, loads[side].force.z());
    const Vector2d local = calc_foot_zmp(loads[side], 1e-3 * least);
    sum += f * (soles[side] * Vector3d(local.x(), local.y(), 0.0));
    total += f;
  }
  if (!(total > least)) return false;
  *zmp = sum / total;
  return true;
}

Matrix3d calc_level_attitude(const Vector3d& a) {
  if (!(a.norm() > 1e-6)) return Matrix3d::Identity();
  const double roll = std::atan2(a.y(), a.z()), pitch = std::atan2(-a.x(), std::hypot(a.y(), a.z()));
  return make_rotation_from_rpy({roll, pitch, 0.0});
}

void AttitudeFilter::update(const Vector3d& gyro_S, const Vector3d& acceleration_S, double dt) {
  Vector3d rate = gyro_S;
  if (acceleration_S.norm() > 1e-6) {
    const Vector3d up_S = R_.conjugate() * Vector3d::UnitZ();
    rate += acceleration_S.normalized().cross(up_S) / time_constant_;
  }
  const double angle = rate.norm() * dt;
  if (angle > 0.0) R_ = (R_ * Eigen::Quaterniond(Eigen::AngleAxisd(angle, rate.normalized()))).normalized();
}

}  // namespace hrp::walking
