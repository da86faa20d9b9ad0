// SPDX-License-Identifier: BSD-3-Clause
#include "controller/ros/trajectory.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace hrp {
namespace {

constexpr double kExact = 1e-12;  // a few roundings of numbers of size 1

JointCommand make_command(double q, double qd, double effort) {
  JointCommand command;
  command.q = Eigen::VectorXd::Constant(1, q);
  command.qd = Eigen::VectorXd::Constant(1, qd);
  command.effort = Eigen::VectorXd::Constant(1, effort);
  return command;
}

TEST(CubicSegment, MeetsPositionsAndVelocitiesAtBothEnds) {
  const CubicSegment segment = make_cubic(0.3, -1.0, 0.8, 2.0, 0.4);
  EXPECT_EQ(segment.find_position(0.0), 0.3);
  EXPECT_EQ(segment.find_velocity(0.0), -1.0);
  EXPECT_NEAR(segment.find_position(0.4), 0.8, kExact);
  EXPECT_NEAR(segment.find_velocity(0.4), 2.0, kExact);
}

TEST(CubicSegment, FromRestToRestIsFastestInTheMiddleByThreeHalvesOfTheMean) {
  const CubicSegment segment = make_cubic(1.0, 0.0, 3.0, 0.0, 4.0);
  EXPECT_NEAR(segment.find_position(2.0), 2.0, kExact);
  EXPECT_NEAR(segment.find_velocity(2.0), 1.5 * 0.5, kExact);
  EXPECT_NEAR(calc_velocity_extremes(segment).highest, 0.75, kExact);
  EXPECT_EQ(calc_position_extremes(segment).lowest, 1.0);
}

TEST(CubicSegment, VelocityIsTheDerivativeOfThePosition) {
  const CubicSegment segment = make_cubic(0.3, -1.0, 0.8, 2.0, 0.4);
  constexpr double kStep = 1e-5;  // [s] central difference: its error is b h^2 = 1e-8
  for (const double t : {0.05, 0.1, 0.2, 0.35}) {
    const double difference = (segment.find_position(t + kStep) - segment.find_position(t - kStep)) / (2.0 * kStep);
    EXPECT_NEAR(segment.find_velocity(t), difference, 1e-7);
  }
}

TEST(CubicSegment, AStraightLineHasOneVelocity) {
  const CubicSegment line = make_line(1.0, -1.0, 0.5);
  for (const double t : {0.0, 0.1, 0.5}) EXPECT_EQ(line.find_velocity(t), -4.0);
  EXPECT_EQ(line.find_position(0.25), 0.0);
  EXPECT_EQ(calc_velocity_extremes(line).lowest, -4.0);
  EXPECT_EQ(calc_position_extremes(line).highest, 1.0);
}

TEST(CubicSegment, ExtremesAreThoseOfManySamples) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-2.0, 2.0);
  for (int k = 0; k < 300; ++k) {
    CubicSegment segment =
        make_cubic(number(random), number(random), number(random), number(random), 0.1 + std::abs(number(random)));
    if (k % 10 == 0) segment.b = 0.0;  // parabolas
    if (k % 20 == 0) segment.a = 0.0;  // lines
    double low = segment.q0, high = segment.q0, slow = segment.v0, fast = segment.v0;
    constexpr int kSamples = 2000;
    for (int i = 1; i <= kSamples; ++i) {
      const double t = segment.duration * i / kSamples;
      low = std::min(low, segment.find_position(t));
      high = std::max(high, segment.find_position(t));
      slow = std::min(slow, segment.find_velocity(t));
      fast = std::max(fast, segment.find_velocity(t));
    }
    // Between two samples at most curvature (h / 2)^2 / 2 is missed: h < 1.1e-3 s, |q''| and |q'''| below 3e3.
    const double missed = 5e-4;
    const Extremes q = calc_position_extremes(segment), v = calc_velocity_extremes(segment);
    EXPECT_LE(q.lowest, low + kExact);
    EXPECT_GE(q.highest, high - kExact);
    EXPECT_NEAR(q.lowest, low, missed);
    EXPECT_NEAR(q.highest, high, missed);
    EXPECT_LE(v.lowest, slow + kExact);
    EXPECT_GE(v.highest, fast - kExact);
    EXPECT_NEAR(v.lowest, slow, missed);
    EXPECT_NEAR(v.highest, fast, missed);
  }
}

TEST(Trajectory, GoesThroughItsPointsAndHoldsTheLastOneAtRest) {
  const Trajectory trajectory(
      {{0.0, make_command(0.0, 0.0, 0.0)}, {1.0, make_command(1.0, 2.0, 4.0)}, {3.0, make_command(2.0, 1.0, 8.0)}},
      true);
  EXPECT_NEAR(trajectory.sample(1.0).q[0], 1.0, kExact);
  EXPECT_NEAR(trajectory.sample(1.0).qd[0], 2.0, kExact);
  EXPECT_NEAR(trajectory.sample(1.0 - 1e-9).qd[0], 2.0, 1e-7);  // the velocity has no step there: |q''| 1e-9 s
  EXPECT_NEAR(trajectory.sample(2.0).effort[0], 6.0, kExact);
  for (const double after : {3.0, 3.1, 1e6}) {
    EXPECT_EQ(trajectory.sample(after).q[0], 2.0);
    EXPECT_EQ(trajectory.sample(after).qd[0], 0.0);
    EXPECT_EQ(trajectory.sample(after).effort[0], 8.0);
  }
}

TEST(Trajectory, WithPositionsOnlyIsMadeOfStraightLines) {
  const Trajectory trajectory(
      {{0.0, make_command(0.0, 9.0, 0.0)}, {1.0, make_command(1.0, 9.0, 0.0)}, {2.0, make_command(0.0, 9.0, 0.0)}},
      false);
  EXPECT_NEAR(trajectory.sample(0.25).q[0], 0.25, kExact);
  EXPECT_NEAR(trajectory.sample(0.25).qd[0], 1.0, kExact);
  EXPECT_NEAR(trajectory.sample(1.75).q[0], 0.25, kExact);
  EXPECT_NEAR(trajectory.sample(1.75).qd[0], -1.0, kExact);
}

}  // namespace
}  // namespace hrp
