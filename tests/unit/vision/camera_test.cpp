// SPDX-License-Identifier: BSD-3-Clause
#include "servers/vision/camera.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes.h"

namespace hrp {
namespace {

// A depth is a float of a double: half a unit in its last place.
constexpr double kFloat = 1e-7;

size_t at(const CameraSpec& camera, int u, int v) {
  return static_cast<size_t>(v) * static_cast<size_t>(camera.width) + static_cast<size_t>(u);
}

TEST(Depth, OfThePlaneIsThatOfItsHeightAndTheTilt) {
  const double h = 1.5, tilt = 0.4;
  SeenScene scene(
      "sensors: {camera: {eye: {xyz: [0, 0, 1.5], rpy: [0, 0.4, 0.3], width: 64, height: 48, far: 1000}}}\n");
  const CameraSpec& camera = scene.maker.cameras()[0];
  const Pinhole pinhole = make_pinhole(camera);
  const CameraPicture& picture = scene.see(3.0).pictures[0];
  int seen = 0;
  for (int v = 0; v < camera.height; ++v) {
    // The camera looks down by `tilt`; a row is y below its middle for each metre ahead. A point at depth z is
    // z (sin(tilt) + y cos(tilt)) below the camera, whatever its column: h on the ground.
    const double y = (v - pinhole.cy) / pinhole.f, below = std::sin(tilt) + y * std::cos(tilt);
    for (int u = 0; u < camera.width; ++u) {
      const double depth = picture.depth[at(camera, u, v)];
      if (below <= 0.0) {
        EXPECT_TRUE(std::isinf(depth)) << "above the horizon";
      } else {
        EXPECT_NEAR(depth * below / h, 1.0, kFloat) << u << " " << v;
        ++seen;
      }
    }
  }
  EXPECT_GT(seen, 1000);
}

TEST(Depth, OfASlopeIsThatOfItsAngle) {
  SeenScene scene("ground: {pitch: -0.3}\nsensors: {camera: {eye: {xyz: [0, 0, 1], width: 32, height: 24}}}\n");
  const CameraSpec& camera = scene.maker.cameras()[0];
  const Pinhole pinhole = make_pinhole(camera);
  const CameraPicture& picture = scene.see(3.0).pictures[0];
  for (int v = 0; v < camera.height; ++v) {
    // The slope rises ahead by tan(0.3): 1 - y z = z tan(0.3).
    const double depth = 1.0 / ((v - pinhole.cy) / pinhole.f + std::tan(0.3));
    if (depth > 0.0 && depth < camera.far)
      EXPECT_NEAR(picture.depth[at(camera, 5, v)] / depth, 1.0, kFloat);
    else
      EXPECT_TRUE(std::isinf(picture.depth[at(camera, 5, v)]));
  }
}

// How far a pixel is inside the convex hull of points [pixels]; negative outside.
double calc_depth_in_hull(const std::vector<Eigen::Vector2d>& points, const Eigen::Vector2d& p) {
  double depth = 1e9;
  for (const auto& a : points) {
    for (const auto& b : points) {
      const Eigen::Vector2d along = b - a, normal(-along.y(), along.x());
      if (along.norm() < 1e-9) continue;
      double lowest = 0.0;
      for (const auto& c : points) lowest = std::min(lowest, normal.dot(c - a) / along.norm());
      if (lowest < -1e-9) continue;  // no edge of the hull
      depth = std::min(depth, normal.dot(p - a) / along.norm());
    }
  }
  return depth;
}

// The corners of a box [m], projected by hand: an optical frame has z forward, x right, y down.
std::vector<Eigen::Vector2d> project_corners(const CameraSpec& camera, const Transform& X_WG, const Vector3d& edges) {
  const Pinhole pinhole = make_pinhole(camera);
  std::vector<Eigen::Vector2d> points;
  for (int k = 0; k < 8; ++k) {
    const Vector3d corner =
        X_WG * Vector3d(0.5 * edges.cwiseProduct(Vector3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1)));
    const Vector3d p_C = camera.X_LC.inverse() * corner;
    points.push_back({pinhole.cx - pinhole.f * p_C.y() / p_C.x(), pinhole.cy - pinhole.f * p_C.z() / p_C.x()});
  }
  return points;
}

void expect_silhouette(SeenScene* scene) {
  const CameraSpec& camera = scene->maker.cameras()[0];
  const ObstacleSpec& box = scene->scenario.obstacles[0];
  const auto corners = project_corners(camera, box.X_WG, Vector3d(0.4, 0.3, 0.5));
  const CameraPicture& picture = scene->see(3.0).pictures[0];
  int inside = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const double depth = calc_depth_in_hull(corners, {u, v});
      if (std::abs(depth) < 1e-3) continue;  // [pixels] on an edge single precision decides
      EXPECT_EQ(std::isfinite(picture.depth[at(camera, u, v)]), depth > 0.0)
          << u << " " << v << ", " << depth << " pixels inside";
      inside += depth > 0.0;
    }
  }
  EXPECT_GT(inside, 500) << "the box is in the picture";
}

constexpr char kEye[] =
    "ground: {type: none}\nsensors: {camera: {eye: {xyz: [-1, 0.2, 0.3], rpy: [0.1, 0.2, -0.1], width: 160, height: "
    "120}}}\n";
constexpr char kPose[] = "position: [1, 0.1, 0.05], rpy: [0.3, -0.4, 0.7]";

TEST(Silhouette, OfABoxIsTheHullOfItsProjectedCorners) {
  SeenScene scene(std::string(kEye) + "obstacles: {box: {size: [0.4, 0.3, 0.5], " + kPose + "}}\n");
  expect_silhouette(&scene);
}

// The same box as a mesh.
std::string write_box_mesh() {
  std::string path = ::testing::TempDir() + "/camera_test_box.obj";
  std::ofstream file(path);
  for (int k = 0; k < 8; ++k)
    file << "v " << (k & 1 ? 0.2 : -0.2) << " " << (k & 2 ? 0.15 : -0.15) << " " << (k & 4 ? 0.25 : -0.25) << "\n";
  file
      << "f 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\nf 3 7 8\nf 3 8 4\nf 1 5 7\nf 1 7 3\nf 2 4 8\nf 2 8 6\n";
  return path;
}

TEST(Silhouette, OfAMeshIsTheHullOfItsProjectedCorners) {
  SeenScene scene(std::string(kEye) + "obstacles: {box: {shape: mesh, file: '" + write_box_mesh() + "', " + kPose +
                  "}}\n");
  expect_silhouette(&scene);
}

TEST(Mesh, LooksAsTheSolidThatItDescribes) {
  SeenScene solid(std::string(kEye) + "obstacles: {box: {size: [0.4, 0.3, 0.5], " + kPose + "}}\n");
  SeenScene mesh(std::string(kEye) + "obstacles: {box: {shape: mesh, file: '" + write_box_mesh() + "', " + kPose +
                 "}}\n");
  const CameraPicture &a = solid.see(3.0).pictures[0], &b = mesh.see(3.0).pictures[0];
  size_t seen = 0;
  for (size_t i = 0; i < a.depth.size(); ++i) {
    if (std::isinf(a.depth[i]) || std::isinf(b.depth[i])) continue;
    EXPECT_NEAR(a.depth[i], b.depth[i], 1e-6) << "[m] both are computed in double precision";
    for (size_t k = 3 * i; k < 3 * i + 3; ++k) EXPECT_NEAR(a.rgb[k], b.rgb[k], 1);
    ++seen;
  }
  EXPECT_GT(seen, 500u);
}

TEST(Picture, FollowsAMovingLink) {
  SeenScene scene("ground: {type: none}\nsensors: {camera: {eye: {xyz: [-3, 0, 0.5], width: 200, height: 150}}}\n");
  const CameraSpec& camera = scene.maker.cameras()[0];
  const Pinhole pinhole = make_pinhole(camera);
  for (const double turn : {-0.8, 0.0, 0.5, 2.0}) {
    const CameraPicture& picture = scene.see(turn).pictures[0];
    const auto nearest = std::min_element(picture.depth.begin(), picture.depth.end()) - picture.depth.begin();
    // The ball is at (cos, sin, 0). The point of it with the least depth is on the line through its middle along the
    // axis.
    const double z = 3.0 + std::cos(turn) - 0.1;
    // A ball falls back by d^2 / (2 radius) at d beside its nearest point. The nearest pixel's middle is within 0.71
    // pixels of that; 1.1 as the rays are not parallel.
    const double pixel = z / pinhole.f;
    const int column = nearest % camera.width, row = nearest / camera.width;
    EXPECT_NEAR(picture.depth[static_cast<size_t>(nearest)], z, 1.1 * 0.5 * pixel * pixel / (2 * 0.1)) << "[m]";
    EXPECT_NEAR(column, pinhole.cx - pinhole.f * std::sin(turn) / z, 1.5) << "[pixels]";
    EXPECT_NEAR(row, pinhole.cy + pinhole.f * 0.5 / z, 1.5);
    EXPECT_GT(picture.rgb[3 * static_cast<size_t>(nearest)], 2 * picture.rgb[3 * static_cast<size_t>(nearest) + 1])
        << "it is red";
  }
}

TEST(Picture, OfACameraOnALinkTurnsWithTheLink) {
  SeenScene scene(
      "ground: {type: none}\nobstacles: {wall: {size: [0.2, 20, 20], position: [4.1, 0, 0]}}\n"
      "sensors: {camera: {eye: {link: arm, xyz: [0.2, 0, 0], near: 1, width: 33, height: 25}}}\n");
  const CameraSpec& camera = scene.maker.cameras()[0];
  for (const double turn : {0.0, 0.4, -0.7}) {
    const double ahead = (4.0 - 0.2 * std::cos(turn)) / std::cos(turn);  // [m] to the wall at x = 4, along the arm
    EXPECT_NEAR(scene.see(turn).pictures[0].depth[at(camera, 16, 12)] / ahead, 1.0, kFloat);
  }
}

TEST(Picture, ShowsMovableObjectsWhereTheyAre) {
  SeenScene scene(
      "ground: {type: none}\nobjects: {ball: {shape: sphere, radius: 0.5, mass: 1, position: [3, 0, 0]}}\n"
      "sensors: {camera: {eye: {near: 1.5, width: 33, height: 25}}}\n");
  const CameraSpec& camera = scene.maker.cameras()[0];
  EXPECT_NEAR(scene.see(3.0).pictures[0].depth[at(camera, 16, 12)], 2.5, 3e-7);
  scene.look.objects[0].p_WB.x() = 7.25;
  EXPECT_NEAR(scene.see(3.0).pictures[0].depth[at(camera, 16, 12)], 6.75, 6e-7);
}

TEST(Picture, HasNothingThatIsNearerThanNearOrFartherThanFar) {
  const std::string world =
      "ground: {type: none}\nobstacles: {box: {size: [1, 1, 1]}, wall: {size: [1, 9, 9], position: [3.5, 0, 0]}}\n";
  SeenScene inside(world + "sensors: {camera: {eye: {near: 0.2, width: 3, height: 3}}}\n");
  EXPECT_NEAR(inside.see(3.0).pictures[0].depth[4], 0.5, kFloat) << "the housing from inside";
  SeenScene beyond(world + "sensors: {camera: {eye: {near: 0.6, width: 3, height: 3}}}\n");
  EXPECT_NEAR(beyond.see(3.0).pictures[0].depth[4], 3.0, 3e-7);
  SeenScene short_sighted(world + "sensors: {camera: {eye: {near: 0.6, far: 2.9, width: 3, height: 3}}}\n");
  EXPECT_TRUE(std::isinf(short_sighted.see(3.0).pictures[0].depth[4]));
}

TEST(Picture, IsBrighterWhereTheSunMeetsTheSurfaceMoreStraight) {
  // The sun is high: the top of a box is brighter than the side that is turned away, which is not black.
  SeenScene scene(
      "ground: {type: none}\nobstacles: {box: {size: [1, 1, 1], position: [2, 0, 0], color: [1, 1, 1]}}\n"
      "sensors: {camera: {back: {xyz: [4, 0, 0], rpy: [0, 0, 3.1415927], width: 3, height: 3}, front: {width: 3, "
      "height: 3}, top: {xyz: [2, 0, 3], rpy: [0, 1.5707963, 0], width: 3, height: 3}}}\n");
  const auto& pictures = scene.see(3.0).pictures;
  EXPECT_NEAR(pictures[0].rgb[12], 0.4 * 255, 1.0) << "turned away: what comes from all sides";
  EXPECT_GT(pictures[1].rgb[12], 1.3 * 0.4 * 255) << "towards the sun, at a low angle";
  EXPECT_GT(pictures[2].rgb[12], 220);
}

double calc_spread(const std::vector<float>& noisy, const std::vector<float>& clean) {
  double sum = 0.0, squares = 0.0;
  for (size_t i = 0; i < noisy.size(); ++i) {
    const double error = static_cast<double>(noisy[i]) - clean[i];
    sum += error;
    squares += error * error;
  }
  const double n = static_cast<double>(noisy.size());
  EXPECT_LT(std::abs(sum / n), 4 * 0.01 / std::sqrt(n)) << "no bias: four standard errors";
  return std::sqrt(squares / n);
}

TEST(DepthNoise, HasTheStatedSpreadAndRepeats) {
  const std::string camera = "{xyz: [0, 0, 3], rpy: [0, 1.5707963, 0], near: 1.5, width: 80, height: 60";
  SeenScene scene("sensors: {camera: {clean: " + camera + "}, noisy: " + camera + ", depth_noise: 0.01}}}\nseed: 3\n");
  const std::vector<float> first = scene.see(3.0, 7).pictures[1].depth;
  EXPECT_NEAR(calc_spread(first, scene.result.pictures[0].depth), 0.01, 0.01 * 4 / std::sqrt(2.0 * 4800))
      << "four standard errors";
  EXPECT_NE(scene.see(3.0, 8).pictures[1].depth, first) << "another step";
  EXPECT_EQ(scene.see(3.0, 7).pictures[1].depth, first) << "the same step again";
}

TEST(Look, GivesTheSameBitsWhateverWasSeenBefore) {
  const std::string world =
      "sensors: {camera: {eye: {xyz: [-3, 0, 0.5], rpy: [0, 0.1, 0], color_noise: 0.02, depth_noise: 0.01}}}\n";
  SeenScene one(world), other(world);
  for (const double turn : {0.3, -2.0, 1.0}) one.see(turn, 4);
  const CameraPicture &a = one.see(0.7, 9).pictures[0], &b = other.see(0.7, 9).pictures[0];
  EXPECT_EQ(a.rgb, b.rgb);
  EXPECT_EQ(a.depth, b.depth);
}

TEST(Look, IsDueAtTheFirstControlStepOfEachPeriod) {
  std::vector<uint64_t> due;
  for (uint64_t step = 0; step <= 200; ++step) {
    if (is_look_due(30.0, step, 0.001, 5)) due.push_back(step);
  }
  EXPECT_THAT(due, ::testing::ElementsAre(0, 35, 70, 100, 135, 170, 200)) << "at or after each 33.3 ms";
  int count = 0;
  for (uint64_t step = 0; step < 100000; ++step) count += is_look_due(200.0, step, 0.001, 5);
  EXPECT_EQ(count, 20000) << "every control step";
}

TEST(Visuals, AreTheDrawnShapesWithTheirColoursElseTheCollisionShapes) {
  std::string urdf = kArm;
  SeenScene drawn("sensors: {camera: {eye: {}}}\n", urdf);
  ASSERT_EQ(drawn.robot.visuals.size(), 1u) << "the ball, not the box of collisions";
  EXPECT_EQ(drawn.robot.visuals[0].shape.kind, ShapeKind::kSphere);
  EXPECT_EQ(drawn.robot.visuals[0].color, Vector3d(0.8, 0.1, 0.1));
  const size_t sphere = urdf.find("<sphere radius=\"0.1\"/>");
  SeenScene undrawn("sensors: {camera: {eye: {}}}\n", urdf.replace(sphere, 22, "<mesh filename=\"nowhere.stl\"/>"));
  ASSERT_EQ(undrawn.robot.visuals.size(), 1u);
  EXPECT_EQ(undrawn.robot.visuals[0].shape.kind, ShapeKind::kBox) << "a drawing without its file";
  EXPECT_TRUE(SeenScene("").robot.visuals.empty()) << "nobody looks";
}

}  // namespace
}  // namespace hrp
