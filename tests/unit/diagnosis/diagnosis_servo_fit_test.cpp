// SPDX-License-Identifier: BSD-3-Clause
// Joints that were taken to follow exactly: the servo that moves them comes back from its law.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "diagnosis/floating/fit/servo_fit.h"

namespace hrp::diagnosis::floating {
namespace {

// A servo's samples at 1 kHz for 20 s; encoders and tachometers with noise [rad], [rad/s].
ServoSamples make_samples(double kp, double kd, double noise, double rate_noise, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  ServoSamples s;
  for (int k = 0; k < 20000; ++k) {
    const double t = 1e-3 * k;
    const double e = 3e-3 * std::sin(4 * t + seed) + 1e-3 * std::sin(23 * t),
                 v = 12e-3 * std::cos(4 * t + seed) + 23e-3 * std::cos(23 * t);
    s.error.emplace_back(e + noise * normal(random), v + rate_noise * normal(random));
    s.effort.push_back(kp * e + kd * v + 0.05 * normal(random));
  }
  return s;
}

TEST(ServoFit, StiffnessAndDampingComeBackFromNoisyEncoders) {
  // Noise of the rate as large as the rate itself: plain least squares would halve the damping.
  const ServoFit fit = fit_servo({make_samples(6000, 100, 2e-4, 0.02, 1), make_samples(6000, 100, 2e-4, 0.02, 2)},
                                 {make_samples(6000, 100, 0, 0, 3)});
  ASSERT_TRUE(fit.found);
  EXPECT_NEAR(fit.kp, 6000, 3 * fit.kp_std);
  EXPECT_NEAR(fit.kd, 100, 3 * fit.kd_std);
  EXPECT_LT(fit.kp_std, 60);  // 1 %
  EXPECT_LT(fit.kd_std, 2);   // 2 %
}

TEST(ServoFit, EffortsThatDoNotFollowTheErrorHaveNoServo) {
  ServoSamples s = make_samples(6000, 100, 0, 0, 1);
  for (size_t k = 0; k < s.effort.size(); ++k) s.effort[k] = 20 * std::sin(1e-3 * 2.2 * static_cast<double>(k));
  EXPECT_FALSE(fit_servo({s}, {s}).found);
}

TEST(ServoFit, AJointThatDoesFollowHasNoServo) {
  // What is left of command less position is noise, and efforts hold the robot's weight.
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  ServoSamples s;
  for (int k = 0; k < 5000; ++k) {
    s.error.emplace_back(5e-6 * normal(random), 1e-3 * normal(random));
    s.effort.push_back(30 + 5 * std::sin(4e-3 * k));
  }
  EXPECT_FALSE(fit_servo({s}, {s}).found);
}

}  // namespace
}  // namespace hrp::diagnosis::floating
