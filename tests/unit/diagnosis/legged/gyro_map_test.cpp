// SPDX-License-Identifier: BSD-3-Clause
// A gyroscope against how the body turns by others.
#include "diagnosis/floating/checks/gyro_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "common/spatial/turn.h"

namespace hrp::diagnosis::floating {
namespace {

// Two recordings of 10 s of a body that turns about all axes. `noise` [rad/s] of what the others say.
std::vector<RateMoment> make_moments(const Vector3d& turn, double scale, double noise) {
  std::mt19937 random(31);
  std::normal_distribution<double> normal;
  const Matrix3d R = make_turn(turn).toRotationMatrix();
  std::vector<RateMoment> out;
  for (const int recording : {0, 1}) {
    for (double t = 0; t < 10; t += 0.02) {
      const double p = t + 3 * recording;
      const Vector3d rate(0.4 * std::sin(5 * p), 0.3 * std::sin(7 * p + 1), 0.25 * std::cos(3 * p));
      const Vector3d said = rate + noise * Vector3d(normal(random), normal(random), normal(random));
      const Vector3d zero(0.01, -0.02, 0.005), swings(2 * std::cos(4 * p), 1, 1);
      out.push_back({recording,
                     static_cast<int>(2 * t),
                     R.transpose() * (scale * rate) + zero,
                     {{Matrix3d::Identity(), swings}, {Matrix3d::Identity(), said}}});
    }
  }
  return out;
}

TEST(GyroMap, ATurnOfSomeDegreesIsToldBesideAZeroAndAFootThatSwings) {
  const Vector3d turn(0, 0.15, 0.03);
  const GyroMap map = find_gyro_map(make_moments(turn, 1, 0.03));
  EXPECT_TRUE(map.is_turned);
  EXPECT_FALSE(map.is_scaled);
  EXPECT_LT((map.turn - turn).norm(), 0.015);
  EXPECT_LT(map.usual, 0.5 * map.of_another_time);
}

TEST(GyroMap, AScaleIsToldAndNoTurn) {
  const GyroMap map = find_gyro_map(make_moments(Vector3d::Zero(), 1.1, 0.03));
  EXPECT_TRUE(map.is_scaled);
  EXPECT_FALSE(map.may_be_turned);
  EXPECT_NEAR(map.scale, 1.1, 2 * map.scale_std);
}

TEST(GyroMap, NothingIsToldOfASensorThatIsRight) {
  const GyroMap map = find_gyro_map(make_moments(Vector3d::Zero(), 1, 0.03));
  EXPECT_FALSE(map.may_be_turned);
  EXPECT_FALSE(map.is_scaled);
}

// Noise of one side makes one regression too small and the other one too large: between them is no scale.
TEST(GyroMap, NoiseAsLargeAsTheMotionMakesNoScale) {
  EXPECT_FALSE(find_gyro_map(make_moments(Vector3d::Zero(), 1.1, 0.3)).is_scaled);
}

// Of two feet that stand still and tell noise alone, the nearest one's noise is like the sensor's.
TEST(GyroMap, FeetThatStandStillMakeNoScale) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const auto draw = [&](double size) {
    return Vector3d(size * normal(random), size * normal(random), size * normal(random));
  };
  std::vector<RateMoment> moments;
  for (const int recording : {0, 1}) {
    for (int i = 0; i < 2000; ++i) {
      moments.push_back({recording,
                         i / 25,
                         draw(0.001),
                         {{Matrix3d::Identity(), draw(0.00001)}, {Matrix3d::Identity(), draw(0.0006)}}});
    }
  }
  const GyroMap map = find_gyro_map(moments);
  EXPECT_FALSE(map.is_scaled) << map.scale;
  EXPECT_FALSE(map.is_turned);
}

// A mounting that differs from recording to recording is none.
TEST(GyroMap, RecordingsThatDisagreeAreNotTurned) {
  std::vector<RateMoment> moments = make_moments(Vector3d(0, 0.15, 0), 1, 0.03);
  const std::vector<RateMoment> right = make_moments(Vector3d::Zero(), 1, 0.03);
  for (size_t i = moments.size() / 2; i < moments.size(); ++i) moments[i] = right[i];
  EXPECT_FALSE(find_gyro_map(moments).may_be_turned);
}

}  // namespace
}  // namespace hrp::diagnosis::floating
