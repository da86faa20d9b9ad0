// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/hints.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/rounds.h"

namespace hrp::diagnosis::standing {
namespace {

constexpr double kMostPeriods = 400;  // [1/rad] of sin(p q): 10 periods per motor turn behind a gear of 40

// A drive's effort residual with the smooth quantities that it may depend on.
struct DriveRows {
  std::vector<double> position;
  Eigen::MatrixXd smooth;  // bias, position, speed, direction, acceleration
  Eigen::VectorXd missing;
  double range = 0, step = 0;  // [rad] range of the position; usual move within half a smoothing window
};

DriveRows collect(const StandProblem& p, const Evaluation& evaluation, size_t joint, size_t channel) {
  std::vector<std::array<double, 4>> rows;
  DriveRows out;
  std::vector<double> speed;
  const size_t joints = p.effort.size();
  double half = 0;
  for (size_t r = 0; r < evaluation.size(); ++r) {
    const StandRecording& recording = p.recordings[r];
    if (!recording.train) continue;
    const size_t n = recording.samples.size(), channels = evaluation[r].residuals.size() / n;
    half = recording.window * (recording.time.back() - recording.time.front()) /
           static_cast<double>(recording.time.size() - 1);
    for (size_t s = 0; s < n; ++s) {
      const DriveState& state = evaluation[r].states[s * joints + joint];
      const double missing = evaluation[r].residuals[s * channels + channel];
      rows.push_back({state.encoder, state.velocity, state.acceleration, missing});
      speed.push_back(std::abs(state.velocity));
    }
  }
  const auto n = static_cast<long>(rows.size());
  if (rows.size() < kLeastServoSamples) return out;
  out.smooth.resize(n, 5);
  out.missing.resize(n);
  for (long i = 0; i < n; ++i) {
    const auto& [q, v, a, e] = rows[static_cast<size_t>(i)];
    out.smooth.row(i) << 1, q, v, v > 0 ? 1 : -1, a;
    out.missing(i) = e;
    out.position.push_back(q);
  }
  const auto [low, high] = std::minmax_element(out.position.begin(), out.position.end());
  out.range = *high - *low;
  out.step = half * find_median(std::move(speed));
  return out;
}

// Squared missing effort that a ripple explains beside the smooth columns.
double calc_power(const DriveRows& rows, const Eigen::MatrixXd& Q, const Eigen::VectorXd& left, double periods) {
  Eigen::MatrixXd wave(left.size(), 2);
  for (long i = 0; i < left.size(); ++i) {
    const double angle = periods * rows.position[static_cast<size_t>(i)];
    wave.row(i) << std::sin(angle), std::cos(angle);
  }
  wave -= Q * (Q.transpose() * wave);
  const Eigen::Vector2d b = wave.transpose() * left;
  Eigen::Matrix2d A = wave.transpose() * wave;
  A.diagonal().array() += 1e-9 * A.trace() + 1e-12;
  return b.dot(A.inverse() * b);
}

std::vector<double> find_joint_ripples(const DriveRows& rows) {
  if (rows.position.empty() || rows.range < 2 * M_PI / kMostPeriods) return {};
  const Eigen::MatrixXd Q = Eigen::HouseholderQR<Eigen::MatrixXd>(rows.smooth).householderQ() *
                            Eigen::MatrixXd::Identity(rows.smooth.rows(), rows.smooth.cols());
  const Eigen::VectorXd left = rows.missing - Q * (Q.transpose() * rows.missing);
  // A ripple must turn by less than a radian within half a window, otherwise the smoothing removes it.
  const double most = std::min(kMostPeriods, 1 / std::max(1e-6, rows.step)), step = M_PI / (2 * rows.range);
  std::vector<std::pair<double, double>> peaks;  // -power, wave number
  double before = 0, here = 0;
  for (double p = 2 * M_PI / rows.range; p <= most + step; p += step) {
    const double next = p <= most ? calc_power(rows, Q, left, p) : 0;
    if (here > before && here >= next) peaks.emplace_back(-here, p - step);
    before = here;
    here = next;
  }
  std::sort(peaks.begin(), peaks.end());
  std::vector<double> out;
  for (size_t i = 0; i < std::min(kLookedAt, peaks.size()); ++i) out.push_back(peaks[i].second);
  return out;
}

}  // namespace

std::vector<std::vector<double>> find_ripples(const StandProblem& p, const Evaluation& evaluation) {
  std::vector<std::vector<double>> out(p.effort.size());
  size_t channel = find_drives(p);
  for (size_t j = 0; j < out.size(); ++j) {
    if (p.is_driven(j)) out[j] = find_joint_ripples(collect(p, evaluation, j, channel));
    channel += count_drive_channels(p, j);
  }
  return out;
}

}  // namespace hrp::diagnosis::standing
