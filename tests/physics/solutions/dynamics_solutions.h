// SPDX-License-Identifier: BSD-3-Clause
// Closed forms and high-accuracy references of motion.
#pragma once

#include <array>

#include <Eigen/Dense>

namespace hrp::solutions {

// Two point masses on massless rods in a plane, angles from hanging down, the second relative to the first; integrated
// with Runge-Kutta 4 at a step so small that halving it changes nothing above 1e-12.
struct DoublePendulum {
  double length1 = 0.5, length2 = 0.4, mass1 = 1.2, mass2 = 0.8, gravity = 9.81;
};
std::array<double, 4> integrate_double_pendulum(const DoublePendulum& pendulum, std::array<double, 4> start,
                                                double time);

// Free rotation of a symmetric top (I1 = I2): body-frame angular velocity after `time`.
Eigen::Vector3d calc_symmetric_top_rate(double I1, double I3, const Eigen::Vector3d& w, double time);

// m xdd = -k x - c xd, started at x0 from rest, below critical damping.
double calc_damped_oscillation(double mass, double damping, double stiffness, double x0, double time);

}  // namespace hrp::solutions
