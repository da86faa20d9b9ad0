// SPDX-License-Identifier: BSD-3-Clause
// A recorded pose of the base that is late or in another convention. Legs that stand and the IMU agree against it.
#include "diagnosis/floating/conventions/pose_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "common/spatial/turn.h"
#include "diagnosis/floating/conventions/sensor_frames.h"
#include "diagnosis/floating/fit/shift_columns.h"
#include "tests/test_places.h"
#include "tests/unit/diagnosis/legged/biped.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr Recorded kWithPose{.effort = false, .leans = true, .pose = true};
constexpr double kStep = 0.015;  // [s] one and a half steps of the clock that is looked for

// Columns of a sensor come 0.2 s late, or so many samples.
void delay(const std::string& sensor, Experiment* e, long samples = 50) {
  for (Recording& r : e->recordings) {
    for (auto& [name, column] : r.other) {
      if (name.rfind(sensor + "/", 0) == 0) std::rotate(column.begin(), column.end() - samples, column.end());
    }
  }
}

TEST(PoseFrame, APoseThatIsLateIsToldAndTheImuIsLeftAlone) {
  Experiment e = make_biped({}, kWithPose);
  delay("/base/pose", &e);
  EXPECT_TRUE(find_sensor_frames(e).empty());
  const PoseFrame pose = find_pose_frame(e);
  EXPECT_NEAR(pose.late, 0.2, kStep);
  EXPECT_FALSE(pose.is_turned());
  EXPECT_FALSE(find_pose_frame(convert_pose(e, pose)).any());
}

TEST(PoseFrame, AnImuThatIsLateIsToldAndThePoseIsLeftAlone) {
  Experiment e = make_biped({}, kWithPose);
  delay("/imu/waist", &e);
  const std::vector<SensorFrame> frames = find_sensor_frames(e);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].sensor, "/imu/waist");
  EXPECT_NEAR(frames[0].late, 0.2, kStep);
  EXPECT_TRUE(frames[0].rival.empty());
  EXPECT_FALSE(find_pose_frame(convert_sensor_frames(e, frames)).any());
}

// 1.2 s, of the pose or of the IMU. What was never read is blank: readings that are held would look like a robot that
// stands.
TEST(PoseFrame, AClockThatIsSecondsOffIsToldAndTheOtherIsLeftAlone) {
  for (const std::string sensor : {"/base/pose", "/imu/waist"}) {
    Experiment e = make_biped({}, kWithPose);
    delay(sensor, &e, 300);
    const std::vector<SensorFrame> frames = find_sensor_frames(e);
    const Experiment moved = convert_sensor_frames(e, frames);
    const PoseFrame pose = find_pose_frame(moved);
    EXPECT_EQ(frames.size(), sensor == "/imu/waist" ? 1u : 0u);
    EXPECT_NEAR(frames.empty() ? pose.late : frames[0].late, 1.2, kStep);
    EXPECT_EQ(pose.any(), frames.empty());
    const Experiment right = convert_pose(moved, pose);
    const auto& column =
        right.recordings[0].other.at(sensor + (frames.empty() ? "/position/z" : "/angular_velocity/y"));
    EXPECT_TRUE(std::isnan(column.back()));
    EXPECT_FALSE(std::isnan(column[column.size() - 310]));
  }
}

// Legs that swing freely: nothing tells which of the two clocks is off.
TEST(PoseFrame, WhereNoFootStandsBothClocksAreNamed) {
  Recorded swings = kWithPose;
  swings.leans = false;
  Experiment e = make_biped({}, swings);
  delay("/base/pose", &e);
  const std::vector<SensorFrame> frames = find_sensor_frames(e);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].rival, "/base/pose");
}

TEST(PoseFrame, NoneIsFoundWhereNothingIsHidden) {
  for (const bool leans : {false, true}) {
    Recorded recorded = kWithPose;
    recorded.leans = leans;
    const Experiment e = make_biped({}, recorded);
    EXPECT_TRUE(find_sensor_frames(e).empty());
    EXPECT_FALSE(find_pose_frame(e).any());
  }
}

// The pose as a capture in another convention writes it: q' = world q body, its numbers in another order.
void write_otherwise(const PoseFrame& truth, Experiment* e) {
  const Eigen::Quaterniond world(truth.R_world.transpose()), body(truth.R_body.transpose());
  for (Recording& r : e->recordings) {
    std::vector<double>*p[3], *q[4];
    for (int i = 0; i < 3; ++i) p[i] = &r.other.at(std::string("/base/pose/position/") + "xyz"[i]);
    for (int i = 0; i < 4; ++i) q[i] = &r.other.at(std::string("/base/pose/orientation/") + "xyzw"[i]);
    for (size_t k = 0; k < p[0]->size(); ++k) {
      const Vector3d at = world * Vector3d((*p[0])[k], (*p[1])[k], (*p[2])[k]);
      Eigen::Quaterniond to = world * Eigen::Quaterniond((*q[3])[k], (*q[0])[k], (*q[1])[k], (*q[2])[k]) * body;
      if (truth.order == Order::kInverse) to = to.conjugate();
      Eigen::Vector4d numbers = to.coeffs();  // x y z w
      if (truth.order == Order::kScalarFirst) numbers << to.w(), to.x(), to.y(), to.z();
      for (int i = 0; i < 3; ++i) (*p[i])[k] = at(i);
      for (int i = 0; i < 4; ++i) (*q[i])[k] = numbers(i);
    }
  }
}

Matrix3d turn(double x, double y, double z) { return make_turn(Vector3d(x, y, z)).toRotationMatrix(); }

void expect_found(const PoseFrame& truth, Experiment e) {
  write_otherwise(truth, &e);
  EXPECT_TRUE(find_sensor_frames(e).empty()) << describe(truth);
  const PoseFrame pose = find_pose_frame(e);
  EXPECT_EQ(pose.order, truth.order) << describe(truth);
  EXPECT_TRUE(pose.R_world.isApprox(truth.R_world, 1e-6)) << describe(truth);
  EXPECT_TRUE(pose.R_body.isApprox(truth.R_body, 1e-6)) << describe(truth);
  EXPECT_EQ(pose.late, 0.0);
  EXPECT_FALSE(find_pose_frame(convert_pose(e, pose)).any());
}

const PoseFrame kConventions[] = {
    {Order::kScalarFirst, Matrix3d::Identity(), Matrix3d::Identity(), 0.0, 1.0},
    {Order::kInverse, Matrix3d::Identity(), Matrix3d::Identity(), 0.0, 1.0},
    {Order::kAsNamed, turn(M_PI / 2, 0, 0), Matrix3d::Identity(), 0.0, 1.0},
    {Order::kAsNamed, Matrix3d::Identity(), turn(M_PI / 2, 0, 0), 0.0, 1.0},
    {Order::kAsNamed, Matrix3d::Identity(), turn(0, 0, M_PI / 2), 0.0, 1.0},
};

TEST(PoseFrame, AConventionIsToldAndTheImuIsLeftAlone) {
  for (const PoseFrame& truth : kConventions) expect_found(truth, make_biped({}, kWithPose));
}

// The first recording alone, and so many samples of it, each of 4 ms.
void cut(size_t samples, Experiment* e) {
  e->recordings.resize(1);
  Recording& r = e->recordings[0];
  r.time.resize(samples);
  for (JointColumns& joint : r.joints) joint.signal[0].resize(samples);
  for (auto& [name, column] : r.other) column.resize(samples);
}

TEST(PoseFrame, WhatARecordingIsTooShortForIsSaid) {
  Experiment e = make_biped({}, kWithPose);
  EXPECT_TRUE(list_not_looked_for(e).empty());
  cut(250, &e);
  const std::vector<std::string> texts = list_not_looked_for(e);
  ASSERT_EQ(texts.size(), 1u);
  EXPECT_NE(texts[0].find("clocks"), std::string::npos) << texts[0];
}

// The gyroscope reads a hundred times too much: the force alone tells which axis is up.
TEST(PoseFrame, TheAxisThatIsUpIsToldWhereNoRateAgrees) {
  const PoseFrame truth{Order::kAsNamed, turn(M_PI / 2, 0, 0), Matrix3d::Identity(), 0.0, 1.0};
  Experiment e = make_biped({}, kWithPose);
  for (Recording& r : e.recordings) {
    for (auto& [name, column] : r.other) {
      for (double& x : column) x *= name.find("angular") == std::string::npos ? 1.0 : 100.0;
    }
  }
  write_otherwise(truth, &e);
  EXPECT_TRUE(find_pose_frame(e).R_world.isApprox(truth.R_world, 1e-6));
}

class PoseOfARealWalk : public testing::Test {
 protected:
  void SetUp() override {
    const std::filesystem::path path =
        std::filesystem::path(source_dir()) / "../shared/recordings/icub_walking/experiment.yaml";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there, NOTHING was checked";
    e_ = load_experiment(path.string());
  }
  Experiment e_;
};

TEST_F(PoseOfARealWalk, IsTakenAsItIs) {
  EXPECT_TRUE(find_sensor_frames(e_).empty());
  EXPECT_FALSE(find_pose_frame(e_).any());
}

TEST_F(PoseOfARealWalk, IsToldInAnotherConvention) {
  for (const PoseFrame& truth : kConventions) expect_found(truth, e_);
}

TEST_F(PoseOfARealWalk, IsToldWhereItIsLate) {
  for (Recording& r : e_.recordings) shift_columns("/base/pose", -0.3, &r);
  EXPECT_TRUE(find_sensor_frames(e_).empty());
  EXPECT_NEAR(find_pose_frame(e_).late, 0.3, kStep);
}

TEST_F(PoseOfARealWalk, IsRightWhereTheImuIsLate) {
  for (Recording& r : e_.recordings) shift_columns("/imu/root", -0.3, &r);
  const std::vector<SensorFrame> frames = find_sensor_frames(e_);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_NEAR(frames[0].late, 0.3, 2 * kStep);  // the recorded one is late, too
  EXPECT_TRUE(frames[0].rival.empty());
  EXPECT_FALSE(find_pose_frame(convert_sensor_frames(e_, frames)).any());
}

}  // namespace
}  // namespace hrp::diagnosis::floating
