// SPDX-License-Identifier: BSD-3-Clause
// Gyroscopes with another scale.
#include "diagnosis/measurement/floating/imu_faults.h"

#include <gtest/gtest.h>

#include <string>

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

TEST(ImuFaults, NoneWhereNothingIsHidden) { EXPECT_TRUE(find_faults(make_walk()).empty()); }

}  // namespace
}  // namespace hrp::diagnosis::floating
