// SPDX-License-Identifier: BSD-3-Clause
// Gyroscopes with another scale, and IMUs that are turned.
#include "diagnosis/floating/checks/imu_faults.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/spatial/turn.h"
#include "diagnosis/model/made.h"
#include "tests/unit/diagnosis/legged/biped.h"

namespace hrp::diagnosis::floating {
namespace {

Experiment make_walk() {
  Recorded recorded;
  recorded.pose = true;
  return make_biped({}, recorded);
}

std::vector<ImuFault> find_faults(const Experiment& e) { return find_imu_faults(make_legged_log(e, Half::kEven)); }

TEST(ImuFaults, AGyroscopeAloneHasItsOwnScale) {
  Experiment e = make_walk();
  scale_readings("/imu/waist/angular_velocity", 1.1, &e);
  const std::vector<ImuFault> faults = find_faults(e);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_TRUE(faults[0].map.is_scaled);
  EXPECT_FALSE(faults[0].map.is_turned);
  EXPECT_NEAR(faults[0].map.scale, 1.1, 0.02);
}

// R(turn) takes readings back.
void turn_imu(const Vector3d& turn, Experiment* e) {
  const Matrix3d back = make_turn(turn).toRotationMatrix().transpose();
  for (Recording& r : e->recordings) {
    for (const char* half : {"angular_velocity", "linear_acceleration"}) {
      std::vector<double>* xyz[3];
      for (int i = 0; i < 3; ++i) xyz[i] = &r.other.at(std::string("/imu/waist/") + half + "/" + "xyz"[i]);
      for (size_t k = 0; k < xyz[0]->size(); ++k) {
        const Vector3d v = back * Vector3d((*xyz[0])[k], (*xyz[1])[k], (*xyz[2])[k]);
        for (int i = 0; i < 3; ++i) (*xyz[i])[k] = v(i);
      }
    }
  }
}

// The biped leans about y: its gyroscope tells turns about x and z, and none about y. Feet must stand: those of the
// walk hang below a body that turns, and say that it does not.
// Legs on soft soles tell too little of a turn: 2.65 was the factor of a gyroscope without a fault.
TEST(ImuFaults, AGyroscopeThatReadsTwiceWhatLegsTellIsNoScale) {
  const auto count = [](double factor) {
    Experiment e = make_biped({}, {.leans = true});
    scale_readings("/imu/waist/angular_velocity", factor, &e);
    return find_faults(e).size();
  };
  EXPECT_EQ(count(1.2), 1u);
  EXPECT_EQ(count(2.65), 0u);
}

TEST(ImuFaults, AWholeImuIsTurnedWithItsAccelerometer) {
  for (const bool pose : {true, false}) {
    Experiment e = make_biped({}, {.effort = false, .leans = true, .pose = pose});
    const Vector3d turn(0.15, 0, 0);
    turn_imu(turn, &e);
    const std::vector<ImuFault> faults = find_faults(e);
    ASSERT_EQ(faults.size(), 1u);
    EXPECT_TRUE(faults[0].map.is_turned);
    EXPECT_EQ(faults[0].what, Turned::kWhole);
    EXPECT_FALSE(faults[0].pose_may_be);
    EXPECT_LT((faults[0].map.turn - turn).norm(), kMountingError);
  }
}

TEST(ImuFaults, NoneWhereNothingIsHidden) { EXPECT_TRUE(find_faults(make_walk()).empty()); }

}  // namespace
}  // namespace hrp::diagnosis::floating
