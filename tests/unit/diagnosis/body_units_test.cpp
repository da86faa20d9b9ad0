// SPDX-License-Identifier: BSD-3-Clause
// Logs of a body in other units, made of recordings in SI units: each is told, and nothing of the others.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/floating/conventions/body_units.h"
#include "diagnosis/floating/conventions/gone_gravity.h"
#include "diagnosis/floating/conventions/sensor_frames.h"
#include "diagnosis/floating/fit/shift_columns.h"
#include "tests/shared_files.h"

namespace hrp::diagnosis::floating {
namespace {

void scale(const std::string& sensor, double factor, Experiment* e) {
  for (Recording& r : e->recordings) {
    for (const char* axis : {"/x", "/y", "/z"}) {
      const auto column = r.other.find(sensor + axis);
      if (column == r.other.end()) continue;
      for (double& x : column->second) x *= factor;
    }
  }
}

// The first seconds.
void cut(double seconds, Recording* r) {
  const size_t size = static_cast<size_t>(std::lower_bound(r->time.begin(), r->time.end(), r->time.front() + seconds) -
                                          r->time.begin());
  const auto shorten = [&](std::vector<double>& column) {
    if (!column.empty()) column.resize(size);
  };
  shorten(r->time);
  for (JointColumns& joint : r->joints) {
    for (std::vector<double>& column : joint.signal) shorten(column);
    shorten(joint.command);
    shorten(joint.command_rate);
  }
  for (auto& [name, column] : r->other) shorten(column);
}

class OfAWalk : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const std::string path = find_shared(std::string(GetParam()) + "/experiment.yaml");
    if (path.empty()) GTEST_SKIP() << GetParam() << " is not there, NOTHING was checked";
    e_ = load_experiment(path);
  }
  Experiment e_;
};

TEST_P(OfAWalk, SIUnitsAreNoFinding) {
  const std::vector<BodyUnit> units = find_body_units(e_);
  EXPECT_TRUE(units.empty()) << units[0].sensor << " " << units[0].meaning;
}

TEST_P(OfAWalk, AnAccelerometerInGAndOneWithTheSignOfGravityAreToldAndTakenBack) {
  ASSERT_FALSE(e_.scenario.sensors.imus.empty());
  const std::string sensor = "/imu/" + e_.scenario.sensors.imus[0].name + "/linear_acceleration";
  for (double factor : {1.0 / 9.81, -1.0, -1.0 / 9.81}) {
    Experiment other = e_;
    scale(sensor, factor, &other);
    const std::vector<BodyUnit> units = find_body_units(other);
    ASSERT_EQ(units.size(), 1u);
    EXPECT_EQ(units[0].sensor, sensor);
    EXPECT_NEAR(units[0].scale, factor, 1e-12);
    EXPECT_TRUE(find_body_units(convert_body_units(other, units)).empty());
  }
}

// Turned by half a turn about x as a whole: y and z of both its sensors change their sign.
TEST_P(OfAWalk, AnImuThatHangsUpsideDownIsTurnedAndCountsGravityRightly) {
  if (!e_.scenario.sensors.base_pose) GTEST_SKIP() << "nothing else tells how the body turns";
  const std::string imu = "/imu/" + e_.scenario.sensors.imus[0].name;
  for (Recording& r : e_.recordings) {
    for (const char* column :
         {"/linear_acceleration/y", "/linear_acceleration/z", "/angular_velocity/y", "/angular_velocity/z"}) {
      for (double& x : r.other.at(imu + column)) x = -x;
    }
  }
  const std::vector<BodyUnit> units = find_body_units(e_);
  EXPECT_TRUE(units.empty()) << units[0].sensor << " " << units[0].meaning;
  const std::vector<SensorFrame> frames = find_sensor_frames(e_);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].sensor, imu);
  EXPECT_TRUE(frames[0].R.isApprox(Vector3d(1, -1, -1).asDiagonal().toDenseMatrix(), 1e-9));
}

// Of so short a walk the legs and the pose cannot tell a half turn from the other sign: both are said, or the turn is.
TEST_P(OfAWalk, AnImuThatHangsUpsideDownForASecondIsNoSureSign) {
  const std::string imu = "/imu/" + e_.scenario.sensors.imus[0].name;
  for (Recording& r : e_.recordings) cut(1.0, &r);
  for (Recording& r : e_.recordings) {
    for (const char* column :
         {"/linear_acceleration/y", "/linear_acceleration/z", "/angular_velocity/y", "/angular_velocity/z"}) {
      for (double& x : r.other.at(imu + column)) x = -x;
    }
  }
  for (const BodyUnit& unit : find_body_units(e_)) EXPECT_TRUE(unit.may_hang) << unit.sensor << " " << unit.meaning;
}

// Zeroed while it stood: a body on its feet cannot read nothing on average. What is put back is gravity, upwards.
TEST_P(OfAWalk, AnAccelerometerWithoutGravityIsToldAndGravityPutBack) {
  EXPECT_TRUE(find_gone_gravity(e_).empty());
  const std::string sensor = "/imu/" + e_.scenario.sensors.imus[0].name + "/linear_acceleration";
  Vector3d mean = Vector3d::Zero();
  double count = 0.0;
  for (int a = 0; a < 3; ++a) {
    for (const Recording& r : e_.recordings) {
      for (double x : r.other.at(sensor + "/" + "xyz"[a])) {
        if (std::isfinite(x)) {
          mean(a) += x;
          count += 1.0 / 3.0;
        }
      }
    }
  }
  mean /= count;
  for (int a = 0; a < 3; ++a) {
    for (Recording& r : e_.recordings) {
      for (double& x : r.other.at(sensor + "/" + "xyz"[a])) x -= mean(a);
    }
  }
  const std::vector<GoneGravity> gone = find_gone_gravity(e_);
  ASSERT_EQ(gone.size(), 1u);
  EXPECT_EQ(gone[0].sensor, sensor);
  EXPECT_NEAR(gone[0].value.norm(), 9.81, 0.1);
  const Experiment back = return_gravity(e_, gone);
  EXPECT_TRUE(find_gone_gravity(back).empty());
  EXPECT_TRUE(find_body_units(back).empty());
}

TEST_P(OfAWalk, ForcesInKilogramsAreToldWhereTheFeetBearAWeight) {
  if (!e_.scenario.sensors.base_pose) GTEST_SKIP() << "its forces are raw counts";
  const std::string sensor = "/wrench/" + e_.scenario.sensors.wrenches[0].name + "/force";
  for (const WrenchSpec& w : e_.scenario.sensors.wrenches) scale("/wrench/" + w.name + "/force", 1.0 / 9.81, &e_);
  const std::vector<BodyUnit> units = find_body_units(e_);
  ASSERT_EQ(units.size(), e_.scenario.sensors.wrenches.size());
  EXPECT_EQ(units[0].sensor, sensor);
  EXPECT_NEAR(units[0].scale, 1.0 / 9.81, 1e-12);
  EXPECT_TRUE(find_body_units(convert_body_units(e_, units)).empty());
}

TEST_P(OfAWalk, AGyroscopeInDegreesIsTold) {
  const std::string sensor = "/imu/" + e_.scenario.sensors.imus[0].name + "/angular_velocity";
  scale(sensor, 180.0 / M_PI, &e_);
  const std::vector<BodyUnit> units = find_body_units(e_);
  ASSERT_EQ(units.size(), 1u);
  EXPECT_EQ(units[0].sensor, sensor);
}

// The pose is 0.3 s late, so that no rate of it agrees with the gyroscope: its size tells.
TEST_P(OfAWalk, AGyroscopeInDegreesIsToldBesideALatePose) {
  if (!e_.scenario.sensors.base_pose) GTEST_SKIP() << "no pose";
  const std::string sensor = "/imu/" + e_.scenario.sensors.imus[0].name + "/angular_velocity";
  scale(sensor, 180.0 / M_PI, &e_);
  for (Recording& r : e_.recordings) shift_columns("/base/pose", -0.3, &r);
  const std::vector<BodyUnit> units = find_body_units(e_);
  ASSERT_EQ(units.size(), 1u);
  EXPECT_EQ(units[0].sensor, sensor);
}

TEST_P(OfAWalk, ForcesOfTheFeetOnTheGroundAreTurned) {
  if (std::string(GetParam()).find("go1") != std::string::npos) GTEST_SKIP() << "raw counts, with counts in the air";
  for (const WrenchSpec& wrench : e_.scenario.sensors.wrenches) scale("/wrench/" + wrench.name + "/force", -1.0, &e_);
  const std::vector<BodyUnit> units = find_body_units(e_);
  size_t forces = 0;
  for (const BodyUnit& unit : units) forces += unit.sensor.find("/force") != std::string::npos && unit.scale == -1.0;
  EXPECT_EQ(forces, e_.scenario.sensors.wrenches.size());
}

// A twelfth of the time, at the end: fifty times as much, the other way round.
TEST_P(OfAWalk, ImpactsOfAFallTurnNoForce) {
  if (std::string(GetParam()).find("go1") != std::string::npos) GTEST_SKIP() << "raw counts, with counts in the air";
  for (Recording& r : e_.recordings) {
    for (auto& [name, column] : r.other) {
      for (size_t k = column.size() - column.size() / 12; name.rfind("/wrench/", 0) == 0 && k < column.size(); ++k)
        column[k] *= -50.0;
    }
  }
  for (const BodyUnit& unit : find_body_units(e_)) EXPECT_NE(unit.scale, -1.0) << unit.sensor;
}

INSTANTIATE_TEST_SUITE_P(Shared, OfAWalk,
                         testing::Values("recordings/icub_walking", "recordings/go1_walk", "cases/open/walk-01",
                                         "cases/open/walk-03"),
                         [](const testing::TestParamInfo<const char*>& info) {
                           std::string name = info.param;
                           for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
                           return name;
                         });

}  // namespace
}  // namespace hrp::diagnosis::floating
