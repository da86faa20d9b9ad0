// SPDX-License-Identifier: BSD-3-Clause
// Claims of experiments beyond the paper that are quick to try, without bus (scripts/experiments.sh runs all of them).
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "servers/console/trial/trial.h"
#include "tests/test_places.h"

namespace hrp {
namespace {

Scenario load(const std::string& name) {
  return load_scenario(source_dir() + "/models/scenarios/paper_a/" + name + ".yaml");
}

TEST(Experiments, StairsOfThreeCentimetresAreClimbed) {
  const TrialResult r = Trial(load("beyond_stairs")).run();
  EXPECT_FALSE(r.fallen);
  EXPECT_NEAR(r.travelled.z(), 0.12, 0.01)
      << "four steps of 3 cm; the rubber gives by 1 mm, the pattern keeps the height";
  EXPECT_NEAR(r.travelled.x(), 1.44, 0.15) << "four treads of 0.36 m; settling moves the base by some centimetres";
}

TEST(Experiments, ARunThatFallsCanGoOnAndTellsOfTheFallAsBefore) {
  Scenario scenario = load("fig8");
  const TrialResult until = Trial(scenario).run();
  Trial trial(scenario);
  trial.go_on_after_fall = true;
  const TrialResult on = trial.run();
  ASSERT_TRUE(until.fallen);
  EXPECT_LT(until.duration, scenario.duration);
  EXPECT_NEAR(on.duration, scenario.duration, 1e-9);
  EXPECT_EQ(on.fall_time, until.fall_time);
  EXPECT_EQ(on.largest_lean, until.largest_lean);
  EXPECT_EQ(on.travelled, until.travelled);
}

}  // namespace
}  // namespace hrp
