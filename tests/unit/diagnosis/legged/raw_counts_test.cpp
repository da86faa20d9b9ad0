// SPDX-License-Identifier: BSD-3-Clause
// Vertical forces of the feet in counts of their own.
#include <gtest/gtest.h>

#include <string>

#include "diagnosis/floating/diagnose.h"
#include "tests/unit/diagnosis/legged/biped.h"

namespace hrp::diagnosis::floating {
namespace {

// A foot in the air pulls at its sensor by its weight, as it does in newtons.
TEST(RawCounts, AFootThatHangsOnItsSensorIsNoZeroAndTheGroundBearsIt) {
  Recorded recorded{.lifts = true};
  recorded.six_axes = false;
  recorded.unit = 7.0;
  const Evidence evidence = diagnose_biped({}, recorded);
  int scales = 0;
  for (const Finding& f : evidence.findings) {
    EXPECT_NE(f.effect, "sensor_bias") << f.statement;
    if (f.effect != "sensor_scale") continue;
    ASSERT_FALSE(f.parameters.empty());
    EXPECT_NEAR(f.parameters[0].value[0], 7.0, 0.07) << f.statement;
    ++scales;
  }
  EXPECT_EQ(scales, 2);
}

// Pressure cells that tell half of what they carry, in one recording of a robot whose feet stay on the ground.
TEST(RawCounts, OfFeetThatNeverLeaveTheGroundMayBeAZeroAndAreNoSurerThanTheirRows) {
  Recorded recorded = kLeans;
  recorded.six_axes = false;
  recorded.unit = 0.5;
  Experiment e = make_biped({}, recorded);
  e.recordings.resize(1);
  std::vector<double>& right = e.recordings[0].other.at("/wrench/r/force/z");
  const double first = e.recordings[0].time.front(), last = e.recordings[0].time.back();
  for (size_t k = 0; k < right.size(); ++k) right[k] *= 1.0 - 0.3 * (e.recordings[0].time[k] - first) / (last - first);
  int scales = 0;
  for (const Finding& f : diagnose_legged(e, nullptr).evidence.findings) {
    if (f.effect != "sensor_scale") continue;
    ++scales;
    EXPECT_GT(f.parameters[0].std[0], 0.005) << f.statement;
    EXPECT_EQ(f.grade, Grade::kAmbiguous) << f.statement;
    ASSERT_FALSE(f.alternatives.empty());
    EXPECT_EQ(f.alternatives[0].effect, "sensor_bias");
    EXPECT_LT(f.alternatives[0].parameters[0].value[0], 0.0) << "they read too little";
    EXPECT_NE(f.statement.find("no foot leaves the ground"), std::string::npos) << f.statement;
  }
  EXPECT_EQ(scales, 2);
}

}  // namespace
}  // namespace hrp::diagnosis::floating
