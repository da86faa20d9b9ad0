// SPDX-License-Identifier: BSD-3-Clause
// The pendulum [H03 eq. 7-9], its closed form, the walk primitive and the foot placement of [K01].
#include "controller/walking/lipm.h"

#include <cmath>

#include <gtest/gtest.h>

namespace hrp::walking {
namespace {

const Pendulum kPendulum{0.8, 9.81};

// Acceleration by central difference of the closed form.
Vector2d differentiate(const PendulumState& start, const ZmpSegment& segment, double t) {
  constexpr double h = 1e-4;
  return (calc_state(kPendulum, start, segment, t + h).v - calc_state(kPendulum, start, segment, t - h).v) / (2 * h);
}

TEST(Pendulum, ClosedFormObeysTheEquationOfMotionWhileTheZmpMoves) {
  const PendulumState start{{0.03, -0.07}, {0.2, -0.1}};
  const ZmpSegment segment{0.4, {0.0, 0.05}, {0.1, -0.09}};
  for (double t : {0.05, 0.2, 0.39}) {
    const Vector2d expected = 9.81 / 0.8 * (calc_state(kPendulum, start, segment, t).x - segment.at(t));
    EXPECT_LT((differentiate(start, segment, t) - expected).norm(), 1e-6) << "truncation of the difference, h^2";
  }
}

TEST(Pendulum, ClosedFormObeysTheEquationsOfTheAnkleTorques) {
  const double m = 58.0, u_r = 12.0, u_p = -20.0;
  const Vector2d zmp(-u_p / (m * 9.81), u_r / (m * 9.81));
  const PendulumState start{{0.02, 0.01}, {0.1, -0.2}};
  const ZmpSegment still{1.0, zmp, zmp};
  EXPECT_LT((calc_state(kPendulum, start, still, 0.0).x - start.x).norm(), 1e-15);
  const Vector2d x = calc_state(kPendulum, start, still, 0.3).x;
  // xdd = (g / zc) x + u_p / (m zc), ydd = (g / zc) y - u_r / (m zc).
  const Vector2d expected = 9.81 / 0.8 * x + Vector2d(u_p, -u_r) / (m * 0.8);
  EXPECT_LT((differentiate(start, still, 0.3) - expected).norm(), 1e-6) << "truncation of the difference, h^2";
}

TEST(Pendulum, WithoutTorqueTheOrbitalEnergyStays) {
  const PendulumState start{{-0.1, 0.08}, {0.4, -0.3}};
  const ZmpSegment still{1.0, Vector2d::Zero(), Vector2d::Zero()};
  const auto energy = [](const PendulumState& s, int i) {
    return 0.5 * s.v[i] * s.v[i] - 0.5 * 9.81 / 0.8 * s.x[i] * s.x[i];
  };
  const PendulumState end = calc_state(kPendulum, start, still, 0.7);
  for (int i : {0, 1}) EXPECT_NEAR(energy(end, i), energy(start, i), 1e-12) << "hyperbolic orbit";
}

TEST(WalkPrimitive, WithoutDoubleSupportIsThePublishedFormula) {
  const double Ts = 0.8, Tc = kPendulum.calc_time_constant(), C = std::cosh(Ts / Tc), S = std::sinh(Ts / Tc);
  const PendulumState end = calc_walk_primitive(kPendulum, {0.3, 0.2}, Ts, 0.0);
  EXPECT_NEAR(end.x.x(), 0.15, 1e-12);
  EXPECT_NEAR(end.x.y(), 0.10, 1e-12);
  EXPECT_NEAR(end.v.x(), (C + 1.0) / (Tc * S) * 0.15, 1e-12);
  EXPECT_NEAR(end.v.y(), (C - 1.0) / (Tc * S) * 0.10, 1e-12);
}

TEST(WalkPrimitive, RepeatsStepAfterStepWithDoubleSupport) {
  const double Ts = 0.7, Td = 0.12;
  const PendulumState end = calc_walk_primitive(kPendulum, {0.2, 0.19}, Ts, Td);
  const Vector2d foot(0.2, 0.19);
  const PendulumState touch = calc_state(kPendulum, end, {Td, Vector2d::Zero(), foot}, Td);
  const PendulumState next = calc_state(kPendulum, touch, {Ts, foot, foot}, Ts);
  // Over the next foot, sideways mirrored.
  EXPECT_NEAR(next.x.x() - foot.x(), end.x.x(), 1e-12);
  EXPECT_NEAR(next.x.y() - foot.y(), -end.x.y(), 1e-12);
  EXPECT_NEAR(next.v.x(), end.v.x(), 1e-12);
  EXPECT_NEAR(next.v.y(), -end.v.y(), 1e-12);
}

// The published closed form of the rule, a = 10, b = 1.
TEST(FootPlacement, WithoutDoubleSupportIsThePublishedFormula) {
  const double Ts = 0.8, Tc = kPendulum.calc_time_constant(), C = std::cosh(Ts / Tc), S = std::sinh(Ts / Tc);
  const PendulumState end{{0.12, 0.08}, {0.5, 0.2}}, target{{0.4, 0.1}, {0.6, -0.2}};
  const double D = 10.0 * (C - 1.0) * (C - 1.0) + S * S / (Tc * Tc);
  const Vector2d p = calc_placement(kPendulum, end, {0.0, 0.0}, target, Ts, 0.0);
  for (int i : {0, 1}) {
    const double expected = -10.0 * (C - 1.0) / D * (target.x[i] - C * end.x[i] - Tc * S * end.v[i]) -
                            S / (Tc * D) * (target.v[i] - S / Tc * end.x[i] - C * end.v[i]);
    EXPECT_NEAR(p[i], expected, 1e-9) << "differences of numbers near 10";
  }
}

TEST(FootPlacement, OfAWalkThatRepeatsIsThePlannedFoothold) {
  const double Ts = 0.7, Td = 0.1;
  const PendulumState end = calc_walk_primitive(kPendulum, {0.25, 0.19}, Ts, Td);
  PendulumState target = calc_walk_primitive(kPendulum, {0.25, -0.19}, Ts, Td);
  target.x += Vector2d(0.25, 0.19);
  const Vector2d p = calc_placement(kPendulum, end, Vector2d::Zero(), target, Ts, Td);
  EXPECT_LT((p - Vector2d(0.25, 0.19)).norm(), 1e-9);
}

TEST(Transfer, TakesTheDivergentComponentToItsGoalWithAContinuousZmpWithinTheFeet) {
  const PendulumState end{{0.01, 0.0}, {0.05, 0.27}};
  const Vector2d goal = calc_divergent(kPendulum, end), foot(0.0, 0.09);
  PendulumState state;
  Vector2d zmp = Vector2d::Zero();
  for (const ZmpSegment& segment : calc_transfer(kPendulum, state, Vector2d::Zero(), goal, foot, 1.2)) {
    EXPECT_LT((segment.p0 - zmp).norm(), 1e-12);
    EXPECT_LT(segment.p0.cwiseAbs().maxCoeff(), 0.09) << "between the feet";
    state = calc_state(kPendulum, state, segment, segment.T);
    zmp = segment.p1;
  }
  EXPECT_LT((calc_divergent(kPendulum, state) - goal).norm(), 1e-10) << "hyperbolic growth of rounding";
  EXPECT_LT((zmp - foot).norm(), 1e-12);
}

}  // namespace
}  // namespace hrp::walking
