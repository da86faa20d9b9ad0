// SPDX-License-Identifier: BSD-3-Clause
// Columns of a gyroscope or an accelerometer with another sign or order than the model's axes, beside a right other
// half.
#include "diagnosis/floating/conventions/signed_axes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "common/spatial/rpy.h"
#include "diagnosis/conventions/log_conventions.h"
#include "diagnosis/floating/conventions/sensor_frames.h"
#include "tests/test_places.h"
#include "tests/unit/diagnosis/legged/biped.h"

namespace hrp::diagnosis::floating {
namespace {

// The columns of a sensor hold R^T of what they held.
void write_in_axes(const std::string& sensor, const Matrix3d& R, Experiment* e) {
  for (Recording& r : e->recordings) {
    std::vector<double>* xyz[3];
    for (int i = 0; i < 3; ++i) xyz[i] = &r.other.at(sensor + "/" + "xyz"[i]);
    for (size_t k = 0; k < xyz[0]->size(); ++k) {
      const Vector3d v = R.transpose() * Vector3d((*xyz[0])[k], (*xyz[1])[k], (*xyz[2])[k]);
      for (int i = 0; i < 3; ++i) (*xyz[i])[k] = v(i);
    }
  }
}

Matrix3d flip(int axis) {
  Matrix3d out = Matrix3d::Identity();
  out(axis, axis) = -1.0;
  return out;
}

Matrix3d exchange(int a, int b) {
  Matrix3d out = Matrix3d::Identity();
  out.col(a).swap(out.col(b));
  return out;
}

// The biped leans about y alone.
TEST(SignedAxes, AGyroscopeWhoseAxisIsFlippedIsToldAndThePoseIsLeftAlone) {
  Experiment e = make_biped({}, {.effort = false, .leans = true, .pose = true});
  write_in_axes("/imu/waist/angular_velocity", flip(1), &e);
  const std::vector<SensorFrame> frames = find_sensor_frames(e);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].sensor, "/imu/waist/angular_velocity");
  EXPECT_TRUE(frames[0].R.isApprox(flip(1)));
  const Experiment right = convert_sensor_frames(e, frames);
  EXPECT_TRUE(find_sensor_frames(right).empty());
  EXPECT_FALSE(find_pose_frame(right).any());
}

// A turn of the whole IMU is no matter of its halves.
TEST(SignedAxes, AWholeImuThatIsTurnedIsOneFrame) {
  const Matrix3d R = make_rotation_from_rpy({M_PI, 0, 0});
  Experiment e = make_biped({}, {.effort = false, .leans = true});
  for (const char* half : {"/angular_velocity", "/linear_acceleration"})
    write_in_axes(std::string("/imu/waist") + half, R, &e);
  const std::vector<SensorFrame> frames = find_sensor_frames(e);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].sensor, "/imu/waist");
  EXPECT_TRUE(frames[0].R.isApprox(R, 1e-6));
}

TEST(SignedAxes, EveryOrderAndSignIsATurnAndSignsThatMakeIt) {
  for (const Matrix3d& turn : list_quarter_turns()) {
    for (const double sign : {1.0, -1.0}) {
      const auto [Q, signs] = split_signs(sign * turn);
      EXPECT_NEAR(Q.determinant(), 1.0, 1e-12);
      EXPECT_TRUE((Q * signs.asDiagonal()).isApprox(sign * turn));
    }
  }
  EXPECT_TRUE(split_signs(flip(2)).Q.isIdentity());
  EXPECT_EQ(name_columns(exchange(0, 1) * flip(2)), "y x -z");
}

TEST(SignedAxes, AFlippedAxisIsReportedAsItsScale) {
  LogConventions logged;
  logged.frames.push_back({"/imu/waist/angular_velocity", flip(1), 0.0, 0.01, ""});
  Reports reports;
  reports.report["findings"] = nlohmann::ordered_json::array();
  add_conventions(make_biped({}), logged, &reports);
  ASSERT_EQ(reports.report["findings"].size(), 1u);
  const auto& finding = reports.report["findings"][0];
  EXPECT_EQ(finding["effect"], "sensor_scale");
  EXPECT_EQ(finding["parameters"]["scale"]["value"].get<std::vector<double>>(), (std::vector<double>{1, -1, 1}));
}

// An accelerometer that counts gravity upwards down and 2 % too little: the interval of the product was inside out.
TEST(SignedAxes, AScaleThatAWrongSignIsTakenTogetherWithKeepsItsInterval) {
  LogConventions logged;
  logged.bodies.push_back({"/imu/waist/linear_acceleration", -1.0, "it counts gravity upwards down", false});
  Reports reports;
  const nlohmann::ordered_json scale{{"value", 0.98}, {"std", 0.003}, {"ci95", {0.974, 0.986}}, {"unit", "1"}};
  reports.report["findings"] = {{{"effect", "sensor_scale"},
                                 {"where", {{"sensor", "/imu/waist/linear_acceleration"}}},
                                 {"parameters", {{"scale", scale}}}}};
  add_conventions(make_biped({}), logged, &reports);
  ASSERT_EQ(reports.report["findings"].size(), 1u);
  const auto& both = reports.report["findings"][0]["parameters"]["scale"];
  EXPECT_DOUBLE_EQ(both["value"], -0.98);
  EXPECT_DOUBLE_EQ(both["std"], 0.003);
  EXPECT_EQ(both["ci95"].get<std::vector<double>>(), (std::vector<double>{-0.986, -0.974}));
}

class AxesOfARealWalk : public testing::TestWithParam<std::pair<std::string, Matrix3d>> {};

TEST_P(AxesOfARealWalk, AreToldByLegsThatStand) {
  const std::filesystem::path path =
      std::filesystem::path(source_dir()) / "../shared/recordings/icub_walking/experiment.yaml";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there, NOTHING was checked";
  Experiment e = load_experiment(path.string());
  const auto& [half, R] = GetParam();
  write_in_axes("/imu/root" + half, R, &e);
  const std::vector<SensorFrame> frames = find_sensor_frames(e);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].sensor, "/imu/root" + half);
  EXPECT_TRUE(frames[0].R.isApprox(R)) << frames[0].R;
  EXPECT_FALSE(find_pose_frame(convert_sensor_frames(e, frames)).any());
}

INSTANTIATE_TEST_SUITE_P(Halves, AxesOfARealWalk,
                         testing::Values(std::pair(std::string("/angular_velocity"), flip(0)),
                                         std::pair(std::string("/angular_velocity"), flip(1)),
                                         std::pair(std::string("/angular_velocity"), exchange(0, 1)),
                                         std::pair(std::string("/angular_velocity"), Matrix3d(-Matrix3d::Identity())),
                                         std::pair(std::string("/linear_acceleration"), flip(1))));

}  // namespace
}  // namespace hrp::diagnosis::floating
