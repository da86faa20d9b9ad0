// SPDX-License-Identifier: BSD-3-Clause
// Vertical forces of the feet in counts of their own.
#include <gtest/gtest.h>

#include "tests/unit/diagnosis/legged/biped.h"

namespace hrp::diagnosis::floating {
namespace {

// A foot in the air pulls at its sensor by its weight, as it does in newtons.
TEST(RawCounts, AFootThatHangsOnItsSensorIsNoZeroAndTheGroundBearsIt) {
  Recorded recorded{.lifts = true};
  recorded.six_axes = false, recorded.unit = 7.0;
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

}  // namespace
}  // namespace hrp::diagnosis::floating
