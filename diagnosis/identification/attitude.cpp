// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/attitude.h"

#include <algorithm>

#include "common/spatial/turn.h"
#include "diagnosis/identification/smoothing.h"

namespace hrp::identification {
namespace {

constexpr double kDriftWindow = 2.0;  // [s] where gyroscope drift and accelerometer noise are about equal
constexpr int kDriftThinning = 20;    // the drift is slow: smoothed on every 20th sample

}  // namespace

std::vector<Matrix3d> integrate_gyro(const RobotLog& log, const Vector3d& bias) {
  const auto n = static_cast<size_t>(log.size());
  std::vector<Matrix3d> R(n, Matrix3d::Identity());
  for (size_t k = 1; k < n; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    R[k] = R[k - 1] * make_turn(log.period * (0.5 * (log.gyro.col(i - 1) + log.gyro.col(i)) - bias));
  }
  return R;
}

Samples smooth_drift(const Samples& all, Eigen::Index margin, double period) {
  const auto u = all.middleCols(margin, all.cols() - 2 * margin);
  const Eigen::Index n = u.cols(), m = (n + kDriftThinning - 1) / kDriftThinning;
  Samples coarse = Samples::Zero(3, m);
  Eigen::VectorXd centre(m);
  for (Eigen::Index j = 0; j < m; ++j) {
    const Eigen::Index first = j * kDriftThinning, count = std::min<Eigen::Index>(kDriftThinning, n - first);
    coarse.col(j) = u.middleCols(first, count).rowwise().mean();
    centre[j] = static_cast<double>(first) + 0.5 * static_cast<double>(count - 1);
  }
  Eigen::MatrixXd line(m, 2);
  line << Eigen::VectorXd::Ones(m), centre;
  const Eigen::MatrixXd trend = line.householderQr().solve(coarse.transpose());
  const Samples rest = coarse - (line * trend).transpose();
  const GaussianFilter wide(kDriftWindow, period * kDriftThinning);
  Samples smooth(3, m), result(3, all.cols());
  for (int i = 0; i < 3; ++i) smooth.row(i) = wide.apply(rest.row(i).transpose(), 0).transpose();
  for (Eigen::Index i = 0; i < result.cols(); ++i) {
    const Eigen::Index k = std::clamp<Eigen::Index>(i - margin, 0, n - 1);
    const double at =
        std::clamp((static_cast<double>(k) - centre[0]) / kDriftThinning, 0.0, static_cast<double>(m - 1));
    const Eigen::Index j = std::min<Eigen::Index>(static_cast<Eigen::Index>(at), std::max<Eigen::Index>(m - 2, 0));
    const double s = m > 1 ? at - static_cast<double>(j) : 0.0;
    result.col(i) = (1.0 - s) * smooth.col(j) + s * smooth.col(std::min(j + 1, m - 1)) + trend.row(0).transpose() +
                    trend.row(1).transpose() * static_cast<double>(k);
  }
  return result;
}

void fill_gains(const RobotLog& log, const Vector3d& gyro_bias, Eigen::Index margin, VerticalEstimate* vertical) {
  const Samples& n_I = vertical->n_I;
  auto& gain = vertical->gain;
  const auto column = [&](Eigen::Index k) -> const Matrix3d& { return vertical->R[static_cast<size_t>(k)]; };
  Samples u(3, log.size());
  const auto put = [&](bool is_fast, Samples* out) {
    const Samples slow = smooth_drift(u, margin, log.period);
    out->resize(3, log.size());
    for (Eigen::Index k = 0; k < log.size(); ++k) {
      out->col(k) = column(k).transpose() * (is_fast ? Vector3d(u.col(k) - slow.col(k)) : Vector3d(slow.col(k)));
    }
  };
  // A bias of the accelerometer turns with the IMU, and the drift smoother sees it turn.
  for (int i = 0; i < 3; ++i) {
    for (Eigen::Index k = 0; k < log.size(); ++k) u.col(k) = column(k).col(i) / kGravity;
    put(false, &gain[i]);
  }
  // A late gyroscope gives R(t - delay) = R (1 - delay [w]x): the vertical lags.
  for (Eigen::Index k = 0; k < log.size(); ++k)
    u.col(k) = column(k) * Vector3d(log.gyro.col(k) - gyro_bias).cross(Vector3d(n_I.col(k)));
  put(true, &gain[kDelay]);
  // A bias b of the gyroscope turns the integrated axes by phi = integral of R b: the vertical seems to move by phi x
  // n.
  for (int i = 0; i < 2; ++i) {
    Vector3d phi = Vector3d::Zero();
    for (Eigen::Index k = 0; k < log.size(); ++k) {
      phi += log.period * column(k).col(i);
      u.col(k) = -phi.cross(column(k) * Vector3d(n_I.col(k)));
    }
    put(true, &gain[kGyroBias + i]);
  }
}

}  // namespace hrp::identification
