// SPDX-License-Identifier: BSD-3-Clause
// IMUs that are turned by some degrees, and gyroscopes with another scale.
#include "diagnosis/measurement/floating/imu_faults.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "common/spatial/turn.h"
#include "tests/unit/diagnosis/legged/biped.h"

namespace hrp::diagnosis::floating {
namespace {

// Readings of one sensor as R^T v times a factor.
void change(const std::string& sensor, const Matrix3d& R, double factor, Experiment* e) {
  for (Recording& r : e->recordings) {
    std::vector<double>* xyz[3];
    for (int i = 0; i < 3; ++i) xyz[i] = &r.other.at(sensor + "/" + "xyz"[i]);
    for (size_t k = 0; k < xyz[0]->size(); ++k) {
      const Vector3d v = factor * (R.transpose() * Vector3d((*xyz[0])[k], (*xyz[1])[k], (*xyz[2])[k]));
      for (int i = 0; i < 3; ++i) (*xyz[i])[k] = v(i);
    }
  }
}

Experiment make_walk() {
  Recorded recorded;
  recorded.pose = true;
  return make_biped({}, recorded);
}

std::vector<ImuFault> find_faults(const Experiment& e) { return find_imu_faults(make_legged_log(e, Half::kEven)); }

TEST(ImuFaults, AHousingThatIsTurnedTurnsBothSensors) {
  Experiment e = make_walk();
  const Vector3d turn(0.12, 0, 0);
  for (const char* part : {"/angular_velocity", "/linear_acceleration"}) change(std::string("/imu/waist") + part, make_turn(turn).toRotationMatrix(), 1, &e);
  const std::vector<ImuFault> faults = find_faults(e);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_TRUE(faults[0].map.is_turned);
  EXPECT_EQ(faults[0].what, Turned::kWhole);
  EXPECT_NEAR(faults[0].map.turn.x(), turn.x(), 0.02);
}

TEST(ImuFaults, AGyroscopeAloneHasItsOwnScale) {
  Experiment e = make_walk();
  change("/imu/waist/angular_velocity", Matrix3d::Identity(), 1.1, &e);
  const std::vector<ImuFault> faults = find_faults(e);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_TRUE(faults[0].map.is_scaled);
  EXPECT_FALSE(faults[0].map.is_turned);
  EXPECT_NEAR(faults[0].map.scale, 1.1, 0.02);
}

TEST(ImuFaults, NoneWhereNothingIsHidden) { EXPECT_TRUE(find_faults(make_walk()).empty()); }

}  // namespace
}  // namespace hrp::diagnosis::floating
