// SPDX-License-Identifier: BSD-3-Clause
// Plain 3-D algebra for the inner loops of the multibody algorithms: no expression templates, no alignment rules, every
// operation inlines to scalar code whose order of operations is the order written here.
#pragma once

#include <Eigen/Dense>

namespace hrp::small {

struct V3 {
  double x, y, z;
};

// Columns x, y, z: the layout of Eigen::Matrix3d.
struct M3 {
  V3 x, y, z;
};

// Symmetric matrix.
struct S3 {
  double xx, xy, xz, yy, yz, zz;
};

inline V3 operator+(V3 a, V3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline V3 operator-(V3 a, V3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline V3 operator-(V3 a) { return {-a.x, -a.y, -a.z}; }
inline V3 operator*(V3 a, double s) { return {a.x * s, a.y * s, a.z * s}; }
inline V3& operator+=(V3& a, V3 b) { return a = a + b; }
inline V3& operator-=(V3& a, V3 b) { return a = a - b; }
inline double dot(V3 a, V3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline V3 cross(V3 a, V3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

inline V3 operator*(const M3& A, V3 v) {
  return {A.x.x * v.x + A.y.x * v.y + A.z.x * v.z, A.x.y * v.x + A.y.y * v.y + A.z.y * v.z,
          A.x.z * v.x + A.y.z * v.y + A.z.z * v.z};
}
// A^T v.
inline V3 transpose_times(const M3& A, V3 v) { return {dot(A.x, v), dot(A.y, v), dot(A.z, v)}; }
inline M3 operator*(const M3& A, const M3& B) { return {A * B.x, A * B.y, A * B.z}; }
inline V3 operator*(const S3& A, V3 v) {
  return {A.xx * v.x + A.xy * v.y + A.xz * v.z, A.xy * v.x + A.yy * v.y + A.yz * v.z,
          A.xz * v.x + A.yz * v.y + A.zz * v.z};
}
inline S3 operator+(const S3& A, const S3& B) {
  return {A.xx + B.xx, A.xy + B.xy, A.xz + B.xz, A.yy + B.yy, A.yz + B.yz, A.zz + B.zz};
}
inline S3 operator-(const S3& A, const S3& B) {
  return {A.xx - B.xx, A.xy - B.xy, A.xz - B.xz, A.yy - B.yy, A.yz - B.yz, A.zz - B.zz};
}
inline S3 operator*(double s, const S3& A) { return {s * A.xx, s * A.xy, s * A.xz, s * A.yy, s * A.yz, s * A.zz}; }
// R A R^T.
inline S3 rotate(const M3& R, const S3& A) {
  const V3 a = R * V3{A.xx, A.xy, A.xz}, b = R * V3{A.xy, A.yy, A.yz}, c = R * V3{A.xz, A.yz, A.zz};
  return {a.x * R.x.x + b.x * R.y.x + c.x * R.z.x, a.x * R.x.y + b.x * R.y.y + c.x * R.z.y,
          a.x * R.x.z + b.x * R.y.z + c.x * R.z.z, a.y * R.x.y + b.y * R.y.y + c.y * R.z.y,
          a.y * R.x.z + b.y * R.y.z + c.y * R.z.z, a.z * R.x.z + b.z * R.y.z + c.z * R.z.z};
}

inline V3 load(const double* v) { return {v[0], v[1], v[2]}; }
inline void store(V3 a, double* v) {
  v[0] = a.x;
  v[1] = a.y;
  v[2] = a.z;
}
inline V3 from_eigen(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
inline M3 from_eigen(const Eigen::Matrix3d& A) { return {load(A.data()), load(A.data() + 3), load(A.data() + 6)}; }
inline S3 sym_from_eigen(const Eigen::Matrix3d& A) {
  return {A(0, 0), 0.5 * (A(0, 1) + A(1, 0)), 0.5 * (A(0, 2) + A(2, 0)), A(1, 1), 0.5 * (A(1, 2) + A(2, 1)), A(2, 2)};
}
inline Eigen::Vector3d to_eigen(V3 v) { return {v.x, v.y, v.z}; }
inline Eigen::Matrix3d to_eigen(const M3& A) {
  Eigen::Matrix3d B;
  B << A.x.x, A.y.x, A.z.x, A.x.y, A.y.y, A.z.y, A.x.z, A.y.z, A.z.z;
  return B;
}

}  // namespace hrp::small
