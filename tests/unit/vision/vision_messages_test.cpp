// SPDX-License-Identifier: BSD-3-Clause
#include "servers/vision/translate.h"

#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "common/scene/frames.h"
#include "scenes.h"

namespace hrp {
namespace {

constexpr char kWorld[] =
    "ground: {type: none}\nobstacles: {ball: {shape: sphere, radius: 0.2, position: [3, 0.7, -0.4]}}\n"
    "sensors: {camera: {eye: {link: arm, xyz: [0, 0, 0.1], width: 100, height: 80, near: 1.3}}, lidar: {scan: "
    "{columns: 8, rows: 2, range: [1.3, 9]}}}\n";

float get_float(const std::vector<uint8_t>& bytes, size_t at) {
  float value = 0.0f;
  std::memcpy(&value, &bytes.at(at), sizeof value);
  return value;
}

// A reader of ROS 2 that knows nothing but the messages: where the nearest pixel is, in the camera's optical frame.
Vector3d find_nearest_point(const RosImage& depth, const RosCameraInfo& info) {
  Vector3d nearest(0, 0, 1e9);
  for (uint32_t v = 0; v < depth.height(); ++v) {
    for (uint32_t u = 0; u < depth.width(); ++u) {
      const double z = get_float(depth.data(), v * depth.step() + 4 * u);
      if (z >= nearest.z()) continue;
      nearest = {z * (u - info.k()[2]) / info.k()[0], z * (v - info.k()[5]) / info.k()[4], z};
    }
  }
  return nearest;
}

TEST(CameraMessages, PutAPixelWhereItIsInTheOpticalFrame) {
  SeenScene scene(kWorld);
  RosImage depth;
  RosCameraInfo info;
  const CameraSpec& camera = scene.maker.cameras()[0];
  set_camera_info(camera, 1.25, &info);
  set_depth_image(camera, scene.see().pictures[0], 1.25, &depth);
  // Optical: x right = -y, y down = -z, z forward = x. The ball is at (3, 0.7, -0.4), the camera 0.1 m above the
  // origin.
  const Vector3d expected(-0.7, 0.5, 2.8);
  EXPECT_LT((find_nearest_point(depth, info) - expected).norm(), 0.03)
      << "[m] a pixel is 0.038 m wide there, and has its middle within 0.71 of that";
}

TEST(CameraMessages, HaveSizesEncodingsFramesAndStamps) {
  SeenScene scene(kWorld);
  RosImage color, depth;
  RosCameraInfo info;
  const CameraSpec& camera = scene.maker.cameras()[0];
  const CameraPicture& picture = scene.see().pictures[0];
  set_color_image(camera, picture, 1.25, &color);
  set_depth_image(camera, picture, 1.25, &depth);
  set_camera_info(camera, 1.25, &info);
  EXPECT_EQ(color.encoding(), "rgb8");
  EXPECT_EQ(color.step(), 300u);
  EXPECT_EQ(color.data().size(), 300u * 80);
  EXPECT_EQ(depth.encoding(), "32FC1");
  EXPECT_EQ(depth.data().size(), 400u * 80);
  EXPECT_EQ(info.d(), std::vector<double>(5, 0.0));
  EXPECT_NEAR(info.k()[0], 50 / std::tan(0.6), 1e-12) << "half the width over the tangent of half the field of view";
  EXPECT_EQ(info.k()[2], 49.5) << "the middle between pixels 0 and 99";
  for (const auto* header : {&color.header(), &depth.header(), &info.header()}) {
    EXPECT_EQ(header->frame_id(), "eye_optical_frame");
    EXPECT_EQ(header->stamp().sec(), 1);
    EXPECT_EQ(header->stamp().nanosec(), 250000000u);
  }
}

TEST(LidarMessages, HaveThePointsOfTheScan) {
  SeenScene scene(kWorld);
  RosPointCloud cloud;
  const LidarSpec& lidar = scene.maker.lidars()[0];
  const Points points = scene.see().scans[0];
  set_points(lidar, points, 2.0, &cloud);
  EXPECT_EQ(cloud.header().frame_id(), "scan_frame");
  EXPECT_EQ(cloud.width() * cloud.height(), 16u);
  EXPECT_EQ(cloud.row_step(), 8u * 16);
  ASSERT_EQ(cloud.data().size(), 16u * 16);
  EXPECT_FALSE(cloud.is_dense()) << "most rays meet nothing";
  EXPECT_EQ(cloud.fields().at(3).name(), "intensity");
  for (size_t i = 0; i < points.size(); ++i) {
    const float value = get_float(cloud.data(), 4 * i);
    if (std::isnan(points[i]))
      EXPECT_TRUE(std::isnan(value));
    else
      EXPECT_EQ(value, points[i]);
  }
}

TEST(SensorFrames, HangFromTheirLinks) {
  SeenScene scene(kWorld);
  const auto fixed = FrameTree(scene.robot.tree).make_fixed(scene.scenario.sensors);
  ASSERT_EQ(fixed.size(), 2u) << "the robot has no fixed links of its own";
  EXPECT_EQ(fixed[0].parent, "arm");
  EXPECT_EQ(fixed[0].child, "eye_optical_frame");
  EXPECT_EQ(fixed[0].X_PC.R.col(2), Vector3d::UnitX()) << "z looks along the link";
  EXPECT_EQ(fixed[0].X_PC.R.col(0), Vector3d(-Vector3d::UnitY())) << "x is to the right";
  EXPECT_EQ(fixed[1].parent, "world");
  EXPECT_EQ(fixed[1].child, "scan_frame");
}

}  // namespace
}  // namespace hrp
