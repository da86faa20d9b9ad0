// SPDX-License-Identifier: BSD-3-Clause
#include "servers/vision/lidar.h"

#include <cmath>

#include <gtest/gtest.h>

#include "scenes.h"

namespace hrp {
namespace {

constexpr double kFloat = 1e-7;  // relative: half a unit in a float's last place

Vector3d get_point(const Points& points, const LidarSpec& lidar, int row, int column) {
  const size_t ray = static_cast<size_t>(row) * static_cast<size_t>(lidar.columns) + static_cast<size_t>(column);
  const size_t i = kNumbersPerPoint * ray;
  return {points[i], points[i + 1], points[i + 2]};
}

void expect_point(const Vector3d& point, const Vector3d& expected) {
  EXPECT_LT((point - expected).norm(), 2 * kFloat * expected.norm())
      << point.transpose() << " for " << expected.transpose();
}

TEST(Lidar, InATowerMeasuresItsWallAtEveryElevation) {
  SeenScene scene(
      "ground: {type: none}\nobstacles: {tower: {shape: cylinder, radius: 4, length: 100}}\n"
      "sensors: {lidar: {scan: {columns: 72, rows: 9, elevation: [-0.6, 0.6], range: [1.5, 20]}}}\n");
  const LidarSpec& lidar = scene.maker.lidars()[0];
  const Points& points = scene.see(3.0).scans[0];
  ASSERT_EQ(points.size(), 4u * 72 * 9);
  for (int row = 0; row < lidar.rows; ++row) {
    const double elevation = -0.6 + 1.2 * (row + 0.5) / 9;
    for (int column = 0; column < lidar.columns; ++column) {
      const double azimuth = -M_PI + 2 * M_PI * (column + 0.5) / 72;
      expect_point(get_point(points, lidar, row, column),
                   {4 * std::cos(azimuth), 4 * std::sin(azimuth), 4 * std::tan(elevation)});
    }
  }
}

TEST(Lidar, MeasuresABallAndNothingBesideIt) {
  SeenScene scene(
      "ground: {type: none}\nobstacles: {ball: {shape: sphere, radius: 1, position: [5, 0, 0]}}\n"
      "sensors: {lidar: {scan: {columns: 101, azimuth: [-0.3, 0.3], range: [1.5, 20]}}}\n");
  const LidarSpec& lidar = scene.maker.lidars()[0];
  const Points& points = scene.see(3.0).scans[0];
  for (int column = 0; column < lidar.columns; ++column) {
    const double azimuth = -0.3 + 0.6 * (column + 0.5) / 101;
    const Vector3d point = get_point(points, lidar, 0, column);
    const double aside = 5 * std::sin(azimuth);  // [m] of the ray from the middle of the ball
    if (std::abs(aside) > 1.0) {
      EXPECT_TRUE(std::isnan(point.x())) << azimuth;
      continue;
    }
    const double range = 5 * std::cos(azimuth) - std::sqrt(1 - aside * aside);
    EXPECT_NEAR(point.norm() / range, 1.0, 2e-7);
    EXPECT_NEAR(std::atan2(point.y(), point.x()), azimuth, 1e-7);
  }
}

TEST(Lidar, MeasuresTheGroundInItsOwnFrame) {
  SeenScene scene(
      "sensors: {lidar: {scan: {link: arm, xyz: [0, 0, 2], rpy: [0, 0.1, 0], columns: 8, rows: 1, elevation: [-0.5, "
      "-0.5], range: [0.1, 50]}}}\n");
  const LidarSpec& lidar = scene.maker.lidars()[0];
  for (const double turn : {0.0, 1.0}) {
    const Points& points = scene.see(turn).scans[0];
    for (int column = 0; column < lidar.columns; ++column) {
      const Vector3d point_W = make_rotation_from_rpy({0, 0.1, turn}) * get_point(points, lidar, 0, column);
      EXPECT_NEAR(point_W.z(), -2.0, 2e-6) << "[m] on the ground, 2 m below";
    }
  }
}

TEST(Lidar, SeesNothingOutOfItsRange) {
  const std::string wall = "ground: {type: none}\nobstacles: {wall: {size: [2, 50, 50], position: [6, 0, 0]}}\n";
  const auto measure = [&](const std::string& range) {
    SeenScene scene(wall + "sensors: {lidar: {scan: {columns: 1, azimuth: [0, 0], range: " + range + "}}}\n");
    return scene.see(3.0).scans[0][0];
  };
  EXPECT_NEAR(measure("[1.5, 5.001]"), 5.0, 5e-7);
  EXPECT_TRUE(std::isnan(measure("[1.5, 4.999]")));
  EXPECT_NEAR(measure("[5.001, 8]"), 7.0, 7e-7) << "the back of the wall: what is nearer is not there";
}

TEST(Lidar, GetsLessLightBackFromASurfaceThatItMeetsAskew) {
  SeenScene scene(
      "ground: {type: none}\nobstacles: {wall: {size: [1, 50, 50], position: [5, 0, 0], color: [0.5, 0.5, 0.5]}}\n"
      "sensors: {lidar: {scan: {columns: 1, azimuth: [1, 1], range: [1.5, 20]}, ahead: {columns: 1, azimuth: [0, 0], "
      "range: [1.5, 20]}}}\n");
  const LookResult& seen = scene.see(3.0);
  EXPECT_NEAR(seen.scans[0][3], 0.5 * std::cos(1.0), 1e-7) << "Lambert";
  EXPECT_NEAR(seen.scans[1][3], 0.5, 1e-7);
}

}  // namespace
}  // namespace hrp
