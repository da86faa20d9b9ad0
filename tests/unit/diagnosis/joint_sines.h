// SPDX-License-Identifier: BSD-3-Clause
// Smooth motions of arms for which efforts are calculated: sums of three sines, each joint at frequencies of its own.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <functional>

namespace hrp::diagnosis {

struct JointMotion {
  Eigen::MatrixXd q, v, a;  // sample x joint [rad], [rad/s], [rad/s^2]
};

struct JointSines {
  int joints = 0;
  double step = 0.0, seconds = 0.0;  // [s]
  double per_sine = 0.0, per_joint = 0.0,
         amplitude = 0.0;           // [rad/s] of each further sine and joint, [rad] of the first sine
  std::function<double(int)> rest;  // [rad] by joint, about which it swings
};

inline JointMotion make_joint_sines(const JointSines& of, int recording) {
  const long rows = std::lround(of.seconds / of.step);
  const Eigen::MatrixXd zero = Eigen::MatrixXd::Zero(rows, of.joints);
  JointMotion m{zero, zero, zero};
  for (long k = 0; k < rows; ++k) {
    for (int j = 0; j < of.joints; ++j) {
      m.q(k, j) = of.rest(j);
      for (int i = 1; i <= 3; ++i) {
        const double w = of.per_sine * i + of.per_joint * j + 0.07 * recording, A = of.amplitude / i;
        const double x = w * of.step * static_cast<double>(k) + 2.0 * i * j + recording;
        m.q(k, j) += A * std::sin(x);
        m.v(k, j) += A * w * std::cos(x);
        m.a(k, j) -= A * w * w * std::sin(x);
      }
    }
  }
  return m;
}

}  // namespace hrp::diagnosis
