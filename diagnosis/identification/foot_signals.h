// SPDX-License-Identifier: BSD-3-Clause
// What a foot's bush does, sample by sample: the angles of the sole against the foot link U, and the load that turns
// it.
#pragma once

#include "diagnosis/identification/attitude.h"
#include "diagnosis/identification/bush_angles.h"

namespace hrp::identification {

// By sample, at the rate of the log. Axes: roll, pitch.
struct FootSignals {
  explicit FootSignals(Eigen::Index n) : load(n), rise(n), height(n), zmp(2, n) {
    for (int a = 0; a < kAxes; ++a) {
      for (Eigen::VectorXd* signal : {&angle[a], &torque[a], &arm[a]}) signal->resize(n);
      for (Eigen::VectorXd& g : gain[a]) g.resize(n);
    }
  }
  Eigen::VectorXd angle[kAxes], torque[kAxes];  // [rad], [N m] of the bush
  Eigen::VectorXd arm[kAxes];                   // [N^2] torque per compliance [m/N] of the bush along U's z
  Eigen::VectorXd load, rise, height;           // [N], [m/s^2], [m] along the vertical
  Eigen::VectorXd gain[kAxes][kImuErrors];      // of angles over errors of the IMU
  Eigen::Matrix2Xd zmp;                         // [m] from the bush
};

// `X_UI`: pose of the IMU in the foot link, by sample; `wrench` [N; N m]: of the foot's sensor, with its zero.
FootSignals calc_foot_signals(const RobotLog& log, const std::vector<Transform>& X_UI, const VerticalEstimate& vertical,
                              const SensorZero& zero, const FootFrame& foot, const Samples& wrench);

}  // namespace hrp::identification
