// SPDX-License-Identifier: BSD-3-Clause
// A recording that ends with a fall is used up to it.
#include "diagnosis/conventions/falls.h"

#include <gtest/gtest.h>

#include "tests/test_places.h"

namespace hrp::diagnosis {
namespace {

// The shipped biped, whose first recording has these factors on an accelerometer and on a foot's force, at this sample.
Experiment make_fall(size_t at, double felt, double pressed) {
  Experiment e = load_experiment(source_dir() + "/models/experiments/standing/experiment.yaml");
  Recording& r = e.recordings[0];
  for (auto& [name, column] : r.other) {
    if (name.find("/linear_acceleration/") != std::string::npos) column[at] *= felt;
    if (name.rfind("/wrench/left_foot_ft/force/", 0) == 0) column[at] *= pressed;
  }
  return e;
}

TEST(Falls, ARecordingIsUsedUpToTheCrash) {
  const Experiment fall = make_fall(400, 60.0, 80.0);
  ASSERT_EQ(find_crashes(fall).size(), 1u);
  const double time = fall.recordings[0].time[400];
  EXPECT_NEAR(find_crashes(fall)[0].time, time, 1e-9);
  const Experiment cut = cut_at_crashes(fall);
  EXPECT_LT(cut.recordings[0].time.back(), time - 0.09);
  EXPECT_GT(cut.recordings[0].time.back(), time - 0.2);
  EXPECT_EQ(cut.recordings[1].size(), fall.recordings[1].size());
  EXPECT_NE(cut.warnings.back().find("the robot falls, or is hit"), std::string::npos) << cut.warnings.back();
}

TEST(Falls, AFallAtTheBeginningLeavesTheRecordingOut) {
  const Experiment fall = make_fall(20, 60.0, 80.0);
  EXPECT_EQ(cut_at_crashes(fall).recordings.size(), fall.recordings.size() - 1);
}

// One sensor alone: its log has a glitch. Ten times the weight: a stiff robot that stamps.
TEST(Falls, AGlitchOrAHardLandingIsNone) {
  EXPECT_TRUE(find_crashes(make_fall(400, 60.0, 1.0)).empty());
  EXPECT_TRUE(find_crashes(make_fall(400, 1.0, 80.0)).empty());
  EXPECT_TRUE(find_crashes(make_fall(400, 10.0, 10.0)).empty());
}

}  // namespace
}  // namespace hrp::diagnosis
