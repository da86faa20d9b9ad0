// SPDX-License-Identifier: BSD-3-Clause
// Rigid transforms and rotations in monogram notation (docs/notation.md).
#pragma once

#include <Eigen/Dense>

namespace hrp {

using Eigen::Matrix3d;
using Eigen::Vector3d;
// Spatial vector: angular part first. Velocity [w; v], force [moment; force].
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// X_AB: pose of frame B in frame A. p_AQ = R_AB p_BQ + p_AB.
struct Transform {
  Matrix3d R = Matrix3d::Identity();
  Vector3d p = Vector3d::Zero();  // [m]

  // X_AC = X_AB * X_BC.
  Transform operator*(const Transform& X_BC) const { return {R * X_BC.R, R * X_BC.p + p}; }
  // p_AQ from p_BQ.
  Vector3d operator*(const Vector3d& p_BQ) const { return R * p_BQ + p; }
  Transform inverse() const { return {R.transpose(), -(R.transpose() * p)}; }
};

// [v]x, so that skew(a) * b = a x b.
inline Matrix3d skew(const Vector3d& v) {
  Matrix3d S;
  S << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return S;
}

// Rotation about x, then y, then z of the fixed axes, as URDF's rpy: R = Rz(yaw) Ry(pitch) Rx(roll).
inline Matrix3d make_rotation_from_rpy(const Vector3d& rpy) {
  return (Eigen::AngleAxisd(rpy.z(), Vector3d::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Vector3d::UnitY()) *
          Eigen::AngleAxisd(rpy.x(), Vector3d::UnitX()))
      .toRotationMatrix();
}

}  // namespace hrp
