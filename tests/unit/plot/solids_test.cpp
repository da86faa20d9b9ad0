// SPDX-License-Identifier: BSD-3-Clause
// What pictures of robots rest on: what is in front is drawn last, outlines are convex hulls.
#include "common/plot/solids.h"

#include <cmath>

#include <gtest/gtest.h>

namespace hrp {
namespace {

Solid make_box(const Vector3d& size, const Vector3d& middle) {
  CollisionShape shape;
  shape.size = size;
  return move_solid({Matrix3d::Identity(), middle}, make_solid(shape));
}

// From the robot's front, level.
Camera look_from_the_front() {
  Camera camera;
  camera.azimuth = camera.elevation = 0.0;
  return camera;
}

TEST(DrawingOrder, WhatStandsInFrontIsDrawnLast) {
  const std::vector<Solid> solids{make_box({1, 1, 1}, {3, 0, 0}), make_box({1, 1, 1}, {0, 0, 0}),
                                  make_box({1, 1, 1}, {6, 0, 0})};
  EXPECT_EQ(find_drawing_order(solids, look_from_the_front()), (std::vector<size_t>{1, 0, 2}));
}

TEST(DrawingOrder, ALongFloorUnderACubeIsBehindItAlthoughItsMiddleIsNearer) {
  Camera camera = look_from_the_front();
  camera.elevation = 0.3;
  const std::vector<Solid> solids{make_box({10, 2, 0.1}, {4, 0, -0.05}), make_box({1, 1, 1}, {0, 0, 0.5})};
  EXPECT_EQ(find_drawing_order(solids, camera), (std::vector<size_t>{0, 1}));
}

TEST(DrawingOrder, APegThatSitsInAPlateFromBelowIsHiddenByIt) {
  Camera camera = look_from_the_front();
  camera.elevation = 0.3;
  const std::vector<Solid> solids{make_box({0.1, 0.1, 0.2}, {0.1, 0, -0.1}), make_box({1, 1, 0.4}, {0, 0, 0.15})};
  EXPECT_EQ(find_drawing_order(solids, camera), (std::vector<size_t>{0, 1})) << "its middle is nearer than the plate's";
}

TEST(Camera, MapsMetresAsItsScaleSays) {
  Camera camera = look_from_the_front();
  camera.scale = 50.0;
  const Eigen::Vector2d up = camera.project({7, 0, 1}), left = camera.project({7, 1, 0});
  EXPECT_NEAR((up - Eigen::Vector2d(0, -50)).norm(), 0.0, 1e-9) << "pixels count downward";
  EXPECT_NEAR((left - Eigen::Vector2d(50, 0)).norm(), 0.0, 1e-9)
      << "seen from the front, the robot's left is on the right";
}

TEST(Outline, OfACubeHasSixCornersFromAnOddDirectionAndFourFromTheFront) {
  const Solid cube = make_box({1, 1, 1}, {0, 0, 0});
  const auto count = [&](double azimuth, double elevation) {
    Camera camera;
    camera.azimuth = azimuth;
    camera.elevation = elevation;
    std::vector<Eigen::Vector2d> points;
    for (const Vector3d& v : cube.vertices) points.push_back(camera.project(v));
    return find_outline(points).size();
  };
  EXPECT_EQ(count(0.7, 0.4), 6u);
  EXPECT_EQ(count(0.0, 0.0), 4u);
}

TEST(Solids, FacesLookOutward) {
  CollisionShape cylinder;
  cylinder.kind = ShapeKind::kCylinder;
  cylinder.size = {0.1, 0.3, 0};
  for (const Solid& solid : {make_box({1, 2, 3}, {0, 0, 0}), make_solid(cylinder)}) {
    for (const std::vector<int>& face : solid.faces) {
      const Vector3d a = solid.vertices[size_t(face[0])], b = solid.vertices[size_t(face[1])],
                     c = solid.vertices[size_t(face[2])];
      EXPECT_GT((b - a).cross(c - b).dot(a + b + c), 0.0) << "the middle is at the origin";
    }
  }
}

}  // namespace
}  // namespace hrp
