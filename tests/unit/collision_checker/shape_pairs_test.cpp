// SPDX-License-Identifier: BSD-3-Clause
// Two bodies' shapes touch with all the points that carry them: meshes like the boxes that they describe, cylinders on
// their ends.
#include "servers/collision_checker/shape_pairs.h"

#include <unistd.h>

#include <cmath>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

namespace hrp {
namespace {

CollisionShape make_shape(ShapeKind kind, const Vector3d& size) {
  CollisionShape shape;
  shape.kind = kind;
  shape.size = size;
  return shape;
}

// A box of these edges as a mesh file; a negative edge mirrors it.
CollisionShape make_mesh_box(const Vector3d& size) {
  const std::string path = ::testing::TempDir() + "/pairs_" + std::to_string(getpid()) + ".obj";
  std::ofstream file(path);
  for (int i = 0; i < 8; ++i)
    file << "v " << (i & 1 ? 0.5 : -0.5) << " " << (i & 2 ? 0.5 : -0.5) << " " << (i & 4 ? 0.5 : -0.5) << "\n";
  file
      << "f 1 3 2\nf 2 3 4\nf 5 6 7\nf 6 8 7\nf 1 2 5\nf 2 6 5\nf 3 7 4\nf 4 7 8\nf 1 5 3\nf 3 5 7\nf 2 4 6\nf 4 8 6\n";
  CollisionShape shape = make_shape(ShapeKind::kMesh, Vector3d::Zero());
  shape.mesh = path;
  shape.scale = size;
  return shape;
}

std::vector<ContactPoint> find_contacts(const CollisionShape& a, const Transform& X_WA, const CollisionShape& b,
                                        const Transform& X_WB) {
  ShapePairs pairs;
  const int first = pairs.add(a), second = pairs.add(b);
  std::vector<ContactPoint> points;
  pairs.calc_contacts(first, X_WA, second, X_WB, 8, &points);
  return points;
}

Transform make_pose(const Vector3d& p, const Vector3d& rpy = Vector3d::Zero()) {
  return {make_rotation_from_rpy(rpy), p};
}

// `points` are the corners (+-x, +-y) of a level patch at `z`, each `depth` deep, pushing a upwards (sign 1) or down.
void expect_level_patch(const std::vector<ContactPoint>& points, double x, double y, double z, double depth,
                        double sign) {
  ASSERT_EQ(points.size(), 4u);
  Vector3d sum = Vector3d::Zero();
  for (const ContactPoint& point : points) {
    EXPECT_NEAR(std::abs(point.p_WC.x()), x, 1e-9);
    EXPECT_NEAR(std::abs(point.p_WC.y()), y, 1e-9);
    EXPECT_NEAR(point.p_WC.z(), z, 1.01 * depth) << "points of ridges lie on the other side of the ridge";
    EXPECT_NEAR(point.depth, depth, 1e-9);
    EXPECT_NEAR(point.n_BA_W.z(), sign, 1e-9);
    sum += point.p_WC - Vector3d(0, 0, point.p_WC.z());
  }
  EXPECT_LT(sum.norm(), 1e-9) << "one point at each corner";
}

constexpr double kDepth = 1e-3;  // [m]

class MeshOnAnything : public ::testing::TestWithParam<bool> {};

TEST_P(MeshOnAnything, AMeshBoxRestsOnALargerBoxWithItsFourCorners) {
  const CollisionShape small = make_mesh_box({0.2, 0.1, 0.3}),
                       large = GetParam() ? make_mesh_box({1, 1, 0.2}) : make_shape(ShapeKind::kBox, {1, 1, 0.2});
  const Transform above = make_pose({0, 0, 0.25 - kDepth}), below = make_pose(Vector3d::Zero());
  expect_level_patch(find_contacts(small, above, large, below), 0.1, 0.05, 0.1 - 0.5 * kDepth, kDepth, 1.0);
  expect_level_patch(find_contacts(large, below, small, above), 0.1, 0.05, 0.1 - 0.5 * kDepth, kDepth, -1.0);
}

TEST_P(MeshOnAnything, AMeshBoxThatOverhangsTouchesUpToTheEdgeBelow) {
  const CollisionShape upper = make_mesh_box({0.4, 0.1, 0.2}),
                       lower =
                           GetParam() ? make_mesh_box({0.4, 0.4, 0.2}) : make_shape(ShapeKind::kBox, {0.4, 0.4, 0.2});
  const std::vector<ContactPoint> points =
      find_contacts(upper, make_pose({0.3, 0, 0.2 - kDepth}), lower, make_pose(Vector3d::Zero()));
  double low = 1.0, high = -1.0;
  for (const ContactPoint& point : points) {
    EXPECT_NEAR(point.n_BA_W.z(), 1.0, 1e-9);
    EXPECT_NEAR(point.depth, kDepth, 1e-9);
    low = std::min(low, point.p_WC.x());
    high = std::max(high, point.p_WC.x());
  }
  EXPECT_NEAR(low, 0.1, 1e-9) << "the upper box begins";
  EXPECT_NEAR(high, 0.2, 1e-9) << "the lower box ends";
}

INSTANTIATE_TEST_SUITE_P(OnBoxAndMesh, MeshOnAnything, ::testing::Bool());

TEST(ShapePairs, AMirroredMeshPushesOutwardsToo) {
  const std::vector<ContactPoint> points =
      find_contacts(make_shape(ShapeKind::kSphere, {0.05, 0, 0}), make_pose({0.1, 0.1, 0.15 - kDepth}),
                    make_mesh_box({-1, 1, 0.2}), make_pose(Vector3d::Zero()));
  ASSERT_EQ(points.size(), 1u);
  EXPECT_NEAR(points[0].n_BA_W.z(), 1.0, 1e-9);
  EXPECT_NEAR(points[0].depth, kDepth, 1e-9);
}

TEST(ShapePairs, ABoxThatTouchesTheRimOfAThinPlateIsNotPushedThroughIt) {
  // The box is higher than the plate: its upper corners are above the plate, and far "below" the plate's lower face.
  const std::vector<ContactPoint> points =
      find_contacts(make_shape(ShapeKind::kBox, {0.1, 0.1, 0.08}), make_pose({0.55 - kDepth, 0, 0}),
                    make_mesh_box({1, 1, 0.02}), make_pose(Vector3d::Zero()));
  ASSERT_FALSE(points.empty());
  for (const ContactPoint& point : points)
    EXPECT_LT(point.depth, 1.5 * kDepth) << point.p_WC.transpose() << " n " << point.n_BA_W.transpose();
}

TEST(ShapePairs, ACylinderStandsOnABoxWithItsRim) {
  const std::vector<ContactPoint> points =
      find_contacts(make_shape(ShapeKind::kCylinder, {0.05, 0.2, 0}), make_pose({0, 0, 0.2 - kDepth}),
                    make_shape(ShapeKind::kBox, {1, 1, 0.2}), make_pose(Vector3d::Zero()));
  ASSERT_EQ(points.size(), 4u);
  for (const ContactPoint& point : points) {
    EXPECT_NEAR(point.p_WC.head<2>().norm(), 0.05, 1e-9);
    EXPECT_NEAR(point.depth, kDepth, 1e-9);
  }
}

TEST(ShapePairs, ACylinderThatLiesOnABoxTouchesWithBothEnds) {
  const std::vector<ContactPoint> points = find_contacts(
      make_shape(ShapeKind::kCylinder, {0.05, 0.2, 0}), make_pose({0, 0, 0.15 - kDepth}, {0, M_PI / 2, 0}),
      make_shape(ShapeKind::kBox, {1, 1, 0.2}), make_pose(Vector3d::Zero()));
  ASSERT_EQ(points.size(), 2u);
  EXPECT_NEAR(points[0].p_WC.x() + points[1].p_WC.x(), 0.0, 1e-9);
  EXPECT_NEAR(std::abs(points[0].p_WC.x()), 0.1, 1e-9);
  for (const ContactPoint& point : points) EXPECT_NEAR(point.depth, kDepth, 1e-9);
}

TEST(ShapePairs, CylindersStackOnTheirEndsAndRollOnTheirSides) {
  const CollisionShape can = make_shape(ShapeKind::kCylinder, {0.05, 0.2, 0});
  const std::vector<ContactPoint> stack =
      find_contacts(can, make_pose({0.01, 0, 0.2 - kDepth}), can, make_pose(Vector3d::Zero()));
  EXPECT_GE(stack.size(), 4u);
  for (const ContactPoint& point : stack) {
    EXPECT_NEAR(point.depth, kDepth, 1e-9);
    EXPECT_NEAR(point.n_BA_W.z(), 1.0, 1e-9);
    EXPECT_NEAR(point.p_WC.head<2>().norm(), 0.05, 0.011) << "between the two rims, 10 mm apart";
  }
  EXPECT_EQ(find_contacts(can, make_pose({0.1 - kDepth, 0, 0}), can, make_pose(Vector3d::Zero())).size(), 1u);
}

}  // namespace
}  // namespace hrp
