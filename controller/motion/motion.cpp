// SPDX-License-Identifier: BSD-3-Clause
#include "controller/motion/motion.h"

#include <algorithm>
#include <cmath>

#include "common/base/diagnostics.h"
#include "common/base/ends_with.h"
#include "common/base/read_file.h"
#include "common/base/suggest.h"
#include "controller/motion/motion_text.h"

namespace hrp {
namespace {

// Slopes of frame k: differences to the neighbours, weighted for uneven steps (the parabola through three frames).
Eigen::MatrixXd calc_slopes(const Motion& motion) {
  const Eigen::Index n = motion.positions.cols();
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(motion.positions.rows(), n);
  if (n < 2) return slopes;
  const auto step = [&](Eigen::Index k) { return motion.times[size_t(k) + 1] - motion.times[size_t(k)]; };
  const auto secant = [&](Eigen::Index k) {
    return ((motion.positions.col(k + 1) - motion.positions.col(k)) / step(k)).eval();
  };
  slopes.col(0) = secant(0);
  slopes.col(n - 1) = secant(n - 2);
  for (Eigen::Index k = 1; k + 1 < n; ++k) {
    const double before = step(k - 1), after = step(k);
    slopes.col(k) = (after * secant(k - 1) + before * secant(k)) / (before + after);
  }
  return slopes;
}

}  // namespace

Motion load_motion(const std::string& path, const std::vector<std::string>& joint_order) {
  std::ifstream file = open_input(path);
  const std::string text = read_rest(file, path);
  if (ends_with(path, ".seq")) return parse_seq_motion(text, path, joint_order);
  if (!ends_with(path, ".csv")) refuse_input(path, "is of no known kind, expected a name ending in .csv or .seq");
  if (!joint_order.empty()) refuse_input(path, "names its joints itself; leave out controller.joint_order");
  return parse_csv_motion(text, path);
}

MotionPlayer::MotionPlayer(Motion motion, const std::vector<std::string>& robot_joints, const Eigen::VectorXd& rest,
                           const std::string& path)
    : motion_(std::move(motion)), slopes_(calc_slopes(motion_)), rest_(rest) {
  for (const std::string& joint : motion_.joints) {
    const auto it = std::find(robot_joints.begin(), robot_joints.end(), joint);
    if (it == robot_joints.end()) {
      refuse_input(path, "moves joint '" + joint + "', which the robot does not have" + suggest(joint, robot_joints));
    }
    robot_index_.push_back(static_cast<int>(it - robot_joints.begin()));
  }
}

size_t MotionPlayer::find_interval(double t) const {
  const auto next = std::upper_bound(motion_.times.begin(), motion_.times.end(), t);
  return static_cast<size_t>(next - motion_.times.begin()) - 1;
}

void MotionPlayer::sample(double t, Eigen::VectorXd* q, Eigen::VectorXd* qd) const {
  *q = rest_;
  qd->setZero(rest_.size());
  if (motion_.times.empty()) return;
  const bool outside = t < motion_.times.front() || t >= motion_.times.back();
  if (outside) {
    const Eigen::Index frame = t < motion_.times.front() ? 0 : motion_.positions.cols() - 1;
    for (size_t j = 0; j < robot_index_.size(); ++j) (*q)[robot_index_[j]] = motion_.positions(Eigen::Index(j), frame);
    return;
  }
  const size_t k = find_interval(t);
  const double h = motion_.times[k + 1] - motion_.times[k];
  const double s = (t - motion_.times[k]) / h;
  // Cubic Hermite basis and its derivative, s in [0, 1).
  const double h00 = (1 + 2 * s) * (1 - s) * (1 - s), h10 = s * (1 - s) * (1 - s);
  const double h01 = s * s * (3 - 2 * s), h11 = s * s * (s - 1);
  const double d00 = 6 * s * (s - 1), d10 = (1 - s) * (1 - 3 * s), d11 = s * (3 * s - 2);
  const Eigen::Index a = Eigen::Index(k), b = a + 1;
  for (size_t j = 0; j < robot_index_.size(); ++j) {
    const Eigen::Index r = Eigen::Index(j);
    const double p0 = motion_.positions(r, a), p1 = motion_.positions(r, b);
    const double m0 = slopes_(r, a), m1 = slopes_(r, b);
    (*q)[robot_index_[j]] = h00 * p0 + h10 * h * m0 + h01 * p1 + h11 * h * m1;
    (*qd)[robot_index_[j]] = d00 * (p0 - p1) / h + d10 * m0 + d11 * m1;
  }
}

}  // namespace hrp
