// SPDX-License-Identifier: BSD-3-Clause
// Sensors of the vertical force alone, while their feet swing and land.
#include "diagnosis/floating/checks/air_zeros.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/unit/diagnosis/legged/biped.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kHangs = -4.9;  // [N] what a foot of 0.5 kg makes its sensor read in the air

// The biped bears its weight on one foot in turn. In each swing the left foot touches the ground for 80 of 400 ms.
Experiment make_scraping(double zero) {
  Recorded recorded{.lifts = true};
  recorded.six_axes = false;
  Experiment e = make_biped({}, recorded);
  for (Recording& r : e.recordings) {
    int swung = 0;
    for (double& force : r.other.at("/wrench/l/force/z")) {
      swung = force < kHangs + 2 ? swung + 1 : 0;
      force += zero + (swung % 100 > 60 && swung % 100 <= 80 ? 40 : 0);
    }
  }
  return e;
}

std::vector<AirZero> find_zeros(const Experiment& e) {
  const LeggedLog log = make_legged_log(e, Half::kEven);
  return find_air_zeros(log, find_contacts(log));
}

TEST(AirZeros, AFootThatTouchesTheGroundOnItsWayHasNone) { EXPECT_TRUE(find_zeros(make_scraping(0)).empty()); }

TEST(AirZeros, AreFoundThoughTheFootTouchesTheGround) {
  const std::vector<AirZero> found = find_zeros(make_scraping(12));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].value, 12, 0.6);  // what a fifth of touched samples moves a median of readings that vary by 1 N
}

// A peak of ten times the weight in one sample: nothing says what was between samples, so rows around it weigh less.
// There is no IMU that would feel it.
TEST(Impacts, ThatVerticalForcesAloneSeeMakeTheirRowsRough) {
  Recorded recorded = kLeans;
  recorded.six_axes = false;
  Experiment e = make_biped({}, recorded);
  constexpr size_t kAt = 1000;
  e.recordings[0].other.at("/wrench/l/force/z")[kAt] = 3500;
  const LeggedLog log = make_legged_log(e, Half::kEven);
  const Clip& clip = log.clips[0];
  EXPECT_GT(clip.roughness[kAt], 100);
  EXPECT_LT(clip.roughness[kAt / 2], 10);
}

}  // namespace
}  // namespace hrp::diagnosis::floating
