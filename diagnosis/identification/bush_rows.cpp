// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/bush_rows.h"

#include <algorithm>
#include <cmath>

namespace hrp::identification {
namespace {

using Vector = Eigen::VectorXd;
constexpr double kYieldStep = 0.02;  // of log yield, for the derivative

struct Corrected {
  Vector angle, rate, slope;  // slope: d torque / d angle
};

// What is not linear in the angle must be computed of the angle as it is between the samples of a track and smoothed
// afterwards, as the torque is: hysteresis of a smoothed angle would be 2 % too small.
Vector calc_quick_angle(const MotionTrack& track, size_t foot, int axis, const Vector& angle) {
  const BushTrack& t = track.feet[foot];
  const Vector correction = angle - t.angle[axis];
  const double stride = track.period / track.log_period, first = track.time[0] / track.log_period;
  const auto last = static_cast<double>(correction.size() - 1);
  Vector quick = t.quick[axis];
  for (Eigen::Index k = 0; k < quick.size(); ++k) {
    const double at = std::clamp((static_cast<double>(k) - first) / stride, 0.0, last);
    const auto j = std::min(static_cast<Eigen::Index>(at), std::max<Eigen::Index>(0, correction.size() - 2));
    const double s = at - static_cast<double>(j);
    quick[k] += (1.0 - s) * correction[j] + s * correction[std::min(j + 1, correction.size() - 1)];
    // A foot in the air is taken to stay as it was when it stood: what hysteresis forgets there, `skip` leaves out.
    if (k > 0 && !track.stands[foot][j]) quick[k] = quick[k - 1];
  }
  return quick;
}

// Angle^3 or the Bouc-Wen variable.
Vector calc_cube(const MotionTrack& track, size_t foot, int axis, const Vector& angle) {
  return track.thin(calc_quick_angle(track, foot, axis, angle).array().cube().matrix(), 0);
}
Vector calc_memory(const MotionTrack& track, size_t foot, int axis, const Vector& angle, double yield) {
  return track.thin(calc_hysteresis(calc_quick_angle(track, foot, axis, angle), yield), 0);
}

Corrected correct(const BushTrack& t, int axis, const Layout& layout, Eigen::Index at, const Vector& theta) {
  const Vector errors = theta.segment<kImuErrors>(layout.imu());
  Corrected c;
  c.angle = t.angle[axis] - t.angle_gain[axis] * errors;
  c.rate = t.rate[axis] - t.rate_gain[axis] * errors;
  c.slope = Vector::Constant(c.angle.size(), theta[at]);
  if (layout.law == BushLaw::kHardening) c.slope += 3.0 * theta[at + 4] * c.angle.cwiseAbs2();
  return c;
}

}  // namespace

Eigen::VectorXd calc_hysteresis(const Eigen::VectorXd& angle, double yield) {
  Vector z = Vector::Zero(angle.size());
  for (Eigen::Index k = 1; k < angle.size(); ++k) {
    double turn = (angle[k] - angle[k - 1]) / yield, now = z[k - 1];
    if (now * turn < 0.0) {  // back towards zero, at most to it
      const double back = std::min(std::abs(now), std::abs(turn));
      now += std::copysign(back, turn);
      turn -= std::copysign(back, turn);
    }
    const double limit = std::copysign(1.0, turn);
    z[k] = turn == 0.0 ? now : limit + (now - limit) * std::exp(-std::abs(turn));
  }
  return z;
}

// Rows of [M14 eq. 5]: torque against angle, rate, one and what else the fit knows.
void make_rows(const MotionTrack& track, size_t foot, int axis, const Layout& layout, const Vector& theta, double skip,
               Rows* rows) {
  const BushTrack& t = track.feet[foot];
  const Eigen::Index at = layout.first(foot, axis), all = track.time.size();
  const Corrected c = correct(t, axis, layout, at, theta);
  Eigen::MatrixXd X = Eigen::MatrixXd::Zero(all, layout.size());
  X.col(at) = c.angle;
  X.col(at + 1) = c.rate;
  X.col(at + 2).setOnes();
  X.col(at + 3) = t.acceleration[axis];
  if (layout.law == BushLaw::kHardening) X.col(at + 4) = calc_cube(track, foot, axis, c.angle);
  Vector y = t.torque[axis];
  if (layout.law == BushLaw::kHysteresis) {
    const double yield = theta[layout.yield()];
    X.col(at + 4) = calc_memory(track, foot, axis, c.angle, std::exp(yield));
    const Vector moved = calc_memory(track, foot, axis, c.angle, std::exp(yield + kYieldStep));
    X.col(layout.yield()) = theta[at + 4] * (moved - X.col(at + 4)) / kYieldStep;
    y += X.col(layout.yield()) * theta[layout.yield()];
  }
  X.col(layout.compliance(foot)) = -t.arm[axis];
  for (int i = 0; i < kImuErrors; ++i) {
    const Vector effect = -c.slope.cwiseProduct(t.angle_gain[axis].col(i)) - theta[at + 1] * t.rate_gain[axis].col(i);
    X.col(layout.imu() + i) = effect;
    y += effect * theta[layout.imu() + i];
  }
  const Mask usable = track.find_usable(foot, skip);
  rows->X = usable.cast<double>().matrix().asDiagonal() * X;
  rows->y = usable.cast<double>().matrix().cwiseProduct(y);
  rows->count = static_cast<double>(usable.count());
}

Eigen::VectorXd calc_torque(const MotionTrack& track, size_t foot, int axis, const Layout& layout,
                            const Vector& theta) {
  const BushTrack& t = track.feet[foot];
  const Eigen::Index at = layout.first(foot, axis);
  const Corrected c = correct(t, axis, layout, at, theta);
  // [M14 eq. 4]
  Vector torque = theta[at] * c.angle + theta[at + 1] * c.rate - theta[layout.compliance(foot)] * t.arm[axis];
  torque.array() += theta[at + 2];
  torque += theta[at + 3] * t.acceleration[axis];
  if (layout.law == BushLaw::kHardening) torque += theta[at + 4] * calc_cube(track, foot, axis, c.angle);
  if (layout.law == BushLaw::kHysteresis)
    torque += theta[at + 4] * calc_memory(track, foot, axis, c.angle, std::exp(theta[layout.yield()]));
  return torque;
}

}  // namespace hrp::identification
