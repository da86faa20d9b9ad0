// SPDX-License-Identifier: BSD-3-Clause
// The contact laws of [H03] one by one.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/base/noise.h"
#include "servers/dynamics/contact_law.h"
#include "servers/dynamics/sensors.h"
#include "servers/dynamics/twist_projection.h"

namespace hrp {
namespace {

const Vector3d kCorners[4] = {{0.12, 0.06, 0}, {0.12, -0.06, 0}, {-0.12, 0.06, 0}, {-0.12, -0.06, 0}};

TEST(PointSprings, AreTogetherTheSpringOfAPairWithKOfTheirPlaces) {
  PointContactParameters law;
  law.stiffness = 5e4;
  Matrix6d K = Matrix6d::Zero();
  Vector6d displacement, sum = Vector6d::Zero();
  displacement << 1e-4, -2e-4, 0, 0, 0, -1e-3;  // [turn; translation]: sunk in by 1 mm and tilted
  for (const Vector3d& r : kCorners) {
    const Vector3d n = Vector3d::UnitZ();
    Vector6d a;
    a << r.cross(n), n;
    K += law.stiffness * a * a.transpose();
    const double depth = -n.dot(displacement.tail<3>() + Vector3d(displacement.head<3>()).cross(r));
    const Vector3d f = calc_normal_spring(law, depth).force * n;
    sum.head<3>() += r.cross(f);
    sum.tail<3>() += f;
  }
  EXPECT_LT((-K * displacement - sum).norm(), 1e-10);
}

TEST(NonLinearDamper, GrowsWithThePenetrationAndHasLambdaOfAlpha) {
  PointContactParameters law;
  law.exponent = 1.5;
  law.stiffness = 1e6;
  law.lambda = calc_lambda(2.4, law.stiffness);
  EXPECT_DOUBLE_EQ(law.lambda, 1.5 * 2.4 * 1e6);
  EXPECT_DOUBLE_EQ(calc_damper_coefficient(law, 1e-3), law.lambda * std::pow(1e-3, 1.5));
  EXPECT_EQ(calc_damper_coefficient(law, -1e-3), 0.0);
}

TEST(TangentialForce, IsClippedToTheConeWithItsDirectionKept) {
  PointContactParameters law;
  law.tangential_damping = 100.0;
  Vector3d force = calc_tangential_force(law, Vector3d::Zero(), Vector3d(3, 4, 0));
  EXPECT_EQ(force, Vector3d(-300, -400, 0));
  EXPECT_TRUE(clip_to_cone(100.0, 0.5, &force));
  EXPECT_LT((force - Vector3d(-30, -40, 0)).norm(), 1e-12);
  EXPECT_TRUE(clip_to_cone(-1.0, 0.5, &force));
  EXPECT_EQ(force.norm(), 0.0);
}

TEST(TwistProjection, MeetsTheKktConditionsForRandomTwistsOfASole) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  TwistProjector projector;
  for (int trial = 0; trial < 200; ++trial) {
    projector.reset(0.1);
    for (const Vector3d& r : kCorners) projector.add_point(r, Vector3d::UnitZ());
    Vector6d twist;
    for (int i = 0; i < 6; ++i) twist[i] = normal(random);
    const Vector6d x = projector.project(twist, 2000, 1e-13).x;
    for (int i = 0; i < 4; ++i) {
      const double pressing = -(x.tail<3>() + Vector3d(x.head<3>()).cross(kCorners[i])).z();
      EXPECT_GT(pressing, -1e-10) << "no corner leaves";
      EXPECT_NEAR(projector.calc_pressing_speed(i, x), pressing, 1e-12);
    }
    const ProjectionCheck check = projector.check();
    EXPECT_LT(check.infeasible, 1e-10);
    EXPECT_LT(check.not_complementary, 1e-10);
    EXPECT_LT(check.not_stationary, 1e-12);
    EXPECT_LT(check.pulls, 1e-12);
  }
}

// One of three corners beside one of four: they stop after different numbers of sweeps.
TEST(TwistProjection, OfTwoPairsAtOnceHasTheBitsOfEachAlone) {
  std::mt19937 random(8);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 200; ++trial) {
    TwistProjector alone[2], both[2];
    Vector6d twists[2];
    for (int k = 0; k < 2; ++k) {
      for (TwistProjector* projector : {&alone[k], &both[k]}) {
        projector->reset(0.1);
        for (int i = 0; i < 4 - k; ++i) projector->add_point(kCorners[i], Vector3d::UnitZ());
      }
      for (int i = 0; i < 6; ++i) twists[k][i] = normal(random);
    }
    TwistProjection results[2];
    project_both(both, twists, results);
    for (int k = 0; k < 2; ++k) {
      const TwistProjection expected = alone[k].project(twists[k]);
      EXPECT_EQ(results[k].x, expected.x);
      EXPECT_EQ(results[k].sweeps, expected.sweeps);
      EXPECT_EQ(results[k].residual, expected.residual);
      EXPECT_EQ(both[k].calc_slope(), alone[k].calc_slope());
    }
  }
}

TEST(TwistProjection, LeavesPressingTwistsAndStopsSeparatingOnes) {
  TwistProjector projector;
  projector.reset(0.1);
  for (const Vector3d& r : kCorners) projector.add_point(r, Vector3d::UnitZ());
  Vector6d pressing, leaving;
  pressing << 0, 0, 0, 0.1, 0, -1.0;
  leaving << 0, 0, 0, 0.1, 0, 1.0;
  EXPECT_EQ(projector.project(pressing).x, pressing);
  EXPECT_NEAR(projector.project(leaving).x[5], 0.0, 1e-9);
  EXPECT_EQ(projector.project(leaving).x[3], 0.1);  // along the floor nothing is changed
}

TEST(SensorNoise, DependsOnNothingButSeedChannelAndStep) {
  EXPECT_EQ(calc_noise(1, 2, 3), calc_noise(1, 2, 3));
  EXPECT_NE(calc_noise(1, 2, 3), calc_noise(1, 2, 4));
  EXPECT_NE(calc_noise(1, 2, 3), calc_noise(1, 3, 3));
  double sum = 0, square = 0;
  constexpr int kSamples = 100000;
  for (int i = 0; i < kSamples; ++i) {
    const double x = calc_noise(5, 0, static_cast<unsigned long long>(i));
    sum += x;
    square += x * x;
  }
  EXPECT_NEAR(sum / kSamples, 0.0, 4.0 / std::sqrt(kSamples));  // four standard deviations
  EXPECT_NEAR(square / kSamples, 1.0, 4.0 * std::sqrt(2.0 / kSamples));
}

TEST(SensorErrors, MisalignScaleBiasAndQuantiseInThisOrder) {
  SensorErrors errors;
  errors.misalignment = Vector3d(0, 0, M_PI / 2);
  errors.scale = Vector3d(2, 2, 2);
  errors.bias = Vector3d(0.1, 0, 0);
  errors.quantum = 0.5;
  // Turned by 90 degrees about z, the sensor sees world y as its x.
  EXPECT_EQ(apply_errors(errors, Vector3d(0, 1, 0), 1, 0, 0), Vector3d(2.0, 0, 0));
}

}  // namespace
}  // namespace hrp
