// SPDX-License-Identifier: BSD-3-Clause
// Contacts with meshes and height fields: points, normals and depths against what geometry says.
#include <cmath>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/robot/surface_file.h"
#include "servers/collision_checker/collision_world.h"
#include "servers/model_parser/robot_loader.h"
#include "tests/test_places.h"

namespace hrp {
namespace {

using ::testing::Each;
using ::testing::SizeIs;

const std::string kModels = source_dir() + "/models/";

Surface make_grid(int columns, int rows, double spacing, const std::function<double(double, double)>& height) {
  Surface surface;
  surface.columns = columns;
  surface.rows = rows;
  surface.spacing = spacing;
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      surface.heights.push_back(height(find_first_coordinate(columns, spacing) + j * spacing,
                                       -find_first_coordinate(rows, spacing) - i * spacing));
    }
  }
  return surface;
}

// A square of 2 n^2 triangles, seen from above.
Surface make_sheet(int n, double size, const std::function<double(double, double)>& height) {
  Surface surface;
  surface.mesh = make_triangles(make_grid(n + 1, n + 1, size / n, height));
  return surface;
}

// A block whose outside is triangles.
Surface make_block(const Vector3d& low, const Vector3d& high) {
  Surface surface;
  for (int i = 0; i < 8; ++i) {
    surface.mesh.vertices.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(),
                                       i & 4 ? high.z() : low.z());
  }
  surface.mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                            {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return surface;
}

double calc_flat(double, double) { return 0.0; }

// A box of 0.4 x 0.3 x 0.2 m on a surface, without ground.
class BoxOn {
 public:
  explicit BoxOn(Surface surface, const std::string& pose = "", const std::string& more = "") {
    const std::string path = kModels + "test.yaml",
                      head = "robot: " + kModels + "test_robots/box.urdf\nfeet: [box]\nground: {type: none}\n" + more;
    RobotDescription robot = load_robot(parse_scenario(head, path));
    surface.obstacle = "land";
    robot.surfaces.push_back(std::make_shared<Surface>(surface));
    world_ = std::make_unique<CollisionWorld>(
        robot,
        parse_scenario(head + "obstacles: {land: {shape: mesh, file: none.obj, friction: 0.3" + pose + "}}\n", path));
  }
  // With the middle of its lower side here.
  ContactSet find(const Vector3d& p, const Vector3d& rpy = Vector3d::Zero()) {
    State state = world_->start_state();
    state.R_WB = Eigen::Quaterniond(make_rotation_from_rpy(rpy));
    state.p_WB = p + state.R_WB * Vector3d(0, 0, 0.1);
    return world_->calc_contacts(state);
  }

 private:
  std::unique_ptr<CollisionWorld> world_;
};

void expect_four_corners(const ContactSet& contacts, double depth) {
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_EQ(contacts[0].body_b, make_obstacle_index(0));
  EXPECT_EQ(contacts[0].friction, 0.3);
  ASSERT_EQ(contacts[0].points.size(), 4u);
  for (const ContactPoint& point : contacts[0].points) {
    // 1e-12: sums of a few numbers of the size of the box
    EXPECT_NEAR(point.depth, depth, 1e-12);
    EXPECT_NEAR(std::abs(point.p_WC.x()), 0.2, 1e-12);
    EXPECT_NEAR(std::abs(point.p_WC.y()), 0.15, 1e-12);
    EXPECT_NEAR(point.n_BA_W.z(), 1.0, 1e-12);
  }
}

TEST(SurfaceContact, OnAFlatMeshABoxTouchesWithItsFourCorners) {
  expect_four_corners(BoxOn(make_sheet(7, 2.0, calc_flat)).find({0, 0, -0.002}), 0.002);
}
TEST(SurfaceContact, OnAFlatFieldABoxTouchesWithItsFourCorners) {
  expect_four_corners(BoxOn(make_grid(60, 50, 0.05, calc_flat)).find({0, 0, -0.002}), 0.002);
}
TEST(SurfaceContact, OnABlockABoxTouchesWithItsFourCorners) {
  expect_four_corners(BoxOn(make_block({-1, -1, -0.3}, {1, 1, 0.0})).find({0, 0, -0.002}), 0.002);
}

TEST(SurfaceContact, NothingTouchesAMillimetreAbove) {
  EXPECT_THAT(BoxOn(make_sheet(7, 2.0, calc_flat)).find({0, 0, 0.001}), SizeIs(0));
  EXPECT_THAT(BoxOn(make_grid(60, 50, 0.05, calc_flat)).find({0, 0, 0.001}), SizeIs(0));
}

TEST(SurfaceContact, CornersOnSeamsOfTrianglesCountOnce) {
  // Seams at every 0.05 m, and the box's corners on them.
  for (const double shift : {0.0, 0.025, 1e-10}) {
    const ContactSet contacts = BoxOn(make_sheet(40, 2.0, calc_flat)).find({shift, shift, -0.001});
    ASSERT_EQ(contacts.size(), 1u);
    EXPECT_EQ(contacts[0].points.size(), 4u) << shift;
  }
}

TEST(SurfaceContact, AFieldsSlopeTurnsTheNormal) {
  const double slope = 0.2;
  const auto incline = [&](double x, double) { return std::tan(slope) * x; };
  const ContactSet contacts =
      BoxOn(make_grid(60, 50, 0.05, incline)).find(Vector3d(0, 0, -0.001 / std::cos(slope)), {0, -slope, 0});
  ASSERT_EQ(contacts.size(), 1u);
  ASSERT_EQ(contacts[0].points.size(), 4u);
  for (const ContactPoint& point : contacts[0].points) {
    EXPECT_NEAR((point.n_BA_W - Vector3d(-std::sin(slope), 0, std::cos(slope))).norm(), 0.0, 1e-12);
    EXPECT_NEAR(point.depth, 0.001, 1e-12);
  }
}

TEST(SurfaceContact, APoseOfTheSurfaceTurnsEverything) {
  BoxOn box(make_sheet(7, 2.0, calc_flat), ", position: [0.1, -0.2, 0.5], rpy: [0.1, -0.2, 0.3]");
  const Matrix3d R = make_rotation_from_rpy({0.1, -0.2, 0.3});
  const ContactSet contacts = box.find(Vector3d(0.1, -0.2, 0.5) - 0.001 * R.col(2), {0.1, -0.2, 0.3});
  ASSERT_EQ(contacts.size(), 1u);
  ASSERT_EQ(contacts[0].points.size(), 4u);
  for (const ContactPoint& point : contacts[0].points) {
    EXPECT_NEAR((point.n_BA_W - R.col(2)).norm(), 0.0, 1e-12);
    EXPECT_NEAR(point.depth, 0.001, 1e-12);
  }
}

TEST(SurfaceContact, TheNoseOfAStepUnderTheSoleCarriesAcrossIt) {
  // The step ends at x = 0, under the middle of the box: two corners stand on it, the nose leaves the sole at both
  // sides.
  const ContactSet contacts = BoxOn(make_block({-1, -1, -0.3}, {0, 1, 0.0})).find({0, 0, -0.002});
  ASSERT_EQ(contacts.size(), 1u);
  ASSERT_EQ(contacts[0].points.size(), 4u);
  double front = 0.0;
  for (const ContactPoint& point : contacts[0].points) {
    EXPECT_NEAR(point.depth, 0.002, 1e-12);
    EXPECT_NEAR(point.n_BA_W.z(), 1.0, 1e-12);
    EXPECT_NEAR(std::abs(point.p_WC.y()), 0.15, 1e-12);
    front = std::max(front, point.p_WC.x());
  }
  EXPECT_NEAR(front, 0.0, 1e-12) << "nothing is carried beyond the nose";
}

TEST(SurfaceContact, APeakUnderTheSolePressesAgainstTheSole) {
  const auto peak = [](double x, double y) { return std::hypot(x, y) < 1e-9 ? 0.01 : 0.0; };
  const ContactSet contacts = BoxOn(make_grid(61, 61, 0.05, peak)).find({0, 0, 0.008}, {0.01, 0, 0});
  ASSERT_EQ(contacts.size(), 1u);
  ASSERT_FALSE(contacts[0].points.empty());
  double deepest = 0.0;
  for (const ContactPoint& point : contacts[0].points) {
    deepest = std::max(deepest, point.depth);
    EXPECT_NEAR((point.n_BA_W - make_rotation_from_rpy({0.01, 0, 0}).col(2)).norm(), 0.0, 1e-9) << "the sole's normal";
  }
  EXPECT_NEAR(deepest, 0.002 * std::cos(0.01), 1e-9);
}

TEST(SurfaceContact, ABoxInTheCornerOfAStepTouchesTreadAndRiser) {
  // The riser stands at x = 0.3 and is 0.5 m high: the box's front is 1 mm in it, its sole 2 mm in the tread.
  Surface stairs = make_sheet(1, 2.0, calc_flat);
  stairs.mesh.vertices = {{-1, -1, 0}, {0.3, -1, 0}, {-1, 1, 0}, {0.3, 1, 0}, {0.3, -1, 0.5}, {0.3, 1, 0.5}};
  stairs.mesh.triangles = {{0, 1, 2}, {1, 3, 2}, {1, 4, 3}, {4, 5, 3}};
  const ContactSet contacts = BoxOn(stairs).find({0.101, 0, -0.002});
  ASSERT_EQ(contacts.size(), 1u);
  int up = 0, back = 0;
  for (const ContactPoint& point : contacts[0].points) {
    const bool tread = point.n_BA_W.z() > 0.999;
    ++(tread ? up : back);
    EXPECT_NEAR(point.depth, tread ? 0.002 : 0.001, 1e-12);
    EXPECT_NEAR(tread ? point.n_BA_W.z() : -point.n_BA_W.x(), 1.0, 1e-12);
  }
  EXPECT_EQ(up, 4);
  EXPECT_EQ(back, 4);
}

TEST(SurfaceContact, BeyondTheEndOfASurfaceNothingTouches) {
  EXPECT_THAT(BoxOn(make_sheet(4, 2.0, calc_flat)).find({1.21, 0, -0.01}), SizeIs(0));
  EXPECT_THAT(BoxOn(make_grid(41, 41, 0.05, calc_flat)).find({1.21, 0, -0.01}), SizeIs(0));
}

TEST(SurfaceContact, AFieldIsSolidAllTheWayDownAMeshIsNot) {
  EXPECT_THAT(BoxOn(make_grid(41, 41, 0.05, calc_flat)).find({0, 0, -0.15}), SizeIs(1));
  EXPECT_THAT(BoxOn(make_sheet(4, 2.0, calc_flat)).find({0, 0, -0.25}), SizeIs(0));
}

// ---- spheres and cylinders ----------------------------------------------------------------------------------------

std::vector<ContactPoint> touch(const Surface& surface, const CollisionShape& shape, const Transform& X) {
  SurfaceMesh mesh(surface);
  const TouchingShape touching = make_touching_shape(shape, Vector3d::Zero(), 0.0);
  std::vector<int> faces;
  mesh.find_faces({X * touching.X_LB, touching.half, mesh.add_query(2.0 * touching.half)}, &faces);
  std::vector<ContactPoint> points;
  calc_surface_contact(mesh, faces, touching, X, &points);
  return points;
}

CollisionShape make_round(ShapeKind kind, double radius, double length = 0.0) {
  CollisionShape shape;
  shape.kind = kind;
  shape.size = {radius, length, 0.0};
  return shape;
}

TEST(SurfaceContact, ABallTouchesATriangleOnce) {
  for (const double x : {0.0, 0.013, 0.1}) {
    const auto points = touch(make_sheet(20, 2.0, calc_flat), make_round(ShapeKind::kSphere, 0.05),
                              {Matrix3d::Identity(), {x, 0.02, 0.049}});
    ASSERT_EQ(points.size(), 1u);
    EXPECT_NEAR(points[0].depth, 0.001, 1e-12);
    EXPECT_NEAR(points[0].p_WC.z(), -0.0005, 1e-12);
  }
}

TEST(SurfaceContact, ABallBesideARidgeIsPushedAwayFromIt) {
  // 30 degrees off the nose at x = 0, z = 0.
  const Vector3d away(std::sin(M_PI / 6.0), 0.0, std::cos(M_PI / 6.0));
  const auto points = touch(make_block({-1, -1, -0.3}, {0, 1, 0}), make_round(ShapeKind::kSphere, 0.05),
                            {Matrix3d::Identity(), 0.049 * away});
  ASSERT_EQ(points.size(), 1u);
  EXPECT_NEAR(points[0].depth, 0.001, 1e-12);
  EXPECT_NEAR((points[0].n_BA_W - away).norm(), 0.0, 1e-12);
}

TEST(SurfaceContact, ABallInAValleyTouchesBothSides) {
  const auto valley = [](double x, double) { return std::abs(x); };
  const double height = 0.05 * std::sqrt(2.0) - 0.001;  // [m] of a ball of 0.05 m that sinks in by 1 mm / sqrt(2)
  const auto points = touch(make_grid(41, 41, 0.05, valley), make_round(ShapeKind::kSphere, 0.05),
                            {Matrix3d::Identity(), {0, 0.01, height}});
  ASSERT_EQ(points.size(), 2u);
  for (const ContactPoint& point : points) {
    EXPECT_NEAR(point.depth, 0.001 / std::sqrt(2.0), 1e-12);
    EXPECT_NEAR(std::abs(point.n_BA_W.x()), std::sqrt(0.5), 1e-12);
  }
}

TEST(SurfaceContact, ALyingCylinderTouchesWithBothEnds) {
  const Matrix3d lying = make_rotation_from_rpy({M_PI / 2.0, 0.0, 0.0});
  const auto points =
      touch(make_sheet(20, 2.0, calc_flat), make_round(ShapeKind::kCylinder, 0.05, 0.21), {lying, {0.01, 0.0, 0.049}});
  ASSERT_EQ(points.size(), 2u);
  for (const ContactPoint& point : points) {
    EXPECT_NEAR(point.depth, 0.001, 1e-9);
    EXPECT_NEAR(std::abs(point.p_WC.y()), 0.105, 1e-9);
  }
}

TEST(SurfaceContact, ADamagedOrderOfVerticesIsABorderAndNoCrash) {
  Surface odd = make_sheet(2, 2.0, calc_flat);
  std::swap(odd.mesh.triangles[1][0], odd.mesh.triangles[1][1]);
  EXPECT_NO_THROW(BoxOn(odd).find({0, 0, -0.002}));
}

}  // namespace
}  // namespace hrp
