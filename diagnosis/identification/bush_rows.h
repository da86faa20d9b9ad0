// SPDX-License-Identifier: BSD-3-Clause
// The regression rows of the bush: one foot, one axis, one motion, linearised about the last parameters.
//
//   measured torque + s arm = K a + C r + O + J r' (+ B a^3) (+ H z),   a = angle - gain e,   r = rate - gain' e
//
// s vertical compliance of the foot, e errors of the IMU, J apparent inertia; a hardening bush has B, a hysteretic one
// H z with the Bouc-Wen variable z of common/effects/joint_law.h.
#pragma once

#include "diagnosis/identification/bush_fit.h"

namespace hrp::identification {

// Where parameters stand: by foot and axis [K, C, O, J (, B or H)], by foot s, then [errors of the IMU (, log yield)].
struct Layout {
  size_t feet = 0;
  BushLaw law = BushLaw::kLinear;
  int each() const { return law == BushLaw::kLinear ? 4 : 5; }
  int errors() const { return law == BushLaw::kHysteresis ? kImuErrors + 1 : kImuErrors; }
  Eigen::Index first(size_t foot, int axis) const {
    return static_cast<Eigen::Index>(foot * kAxes + static_cast<size_t>(axis)) * each();
  }
  Eigen::Index compliance(size_t foot) const { return first(feet, 0) + static_cast<Eigen::Index>(foot); }
  Eigen::Index imu() const { return compliance(feet); }
  Eigen::Index yield() const { return imu() + kImuErrors; }  // kHysteresis only
  Eigen::Index size() const { return imu() + errors(); }
};

struct Rows {
  Eigen::MatrixXd X;   // samples x Layout::size()
  Eigen::VectorXd y;   // [N m]
  double count = 0.0;  // samples that say something: the others are zero, so that rows of all feet keep their times
};

// Samples while the foot does not stand, or has for less than `skip` seconds, say nothing.
void make_rows(const MotionTrack& track, size_t foot, int axis, const Layout& layout, const Eigen::VectorXd& theta,
               double skip, Rows* rows);
// Torque that the parameters predict, all samples.
Eigen::VectorXd calc_torque(const MotionTrack& track, size_t foot, int axis, const Layout& layout,
                            const Eigen::VectorXd& theta);

// Bouc-Wen variable along an angle, from zero: towards the limit z' = (1 - |z|) / yield per rad, back 1 / yield per rad
// (exact for straight pieces).
Eigen::VectorXd calc_hysteresis(const Eigen::VectorXd& angle, double yield);

}  // namespace hrp::identification
