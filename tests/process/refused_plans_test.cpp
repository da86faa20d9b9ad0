// SPDX-License-Identifier: BSD-3-Clause
// Footstep plans that legs cannot walk end a run of the server set before its first step, with the step and the reason.
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/process/server_set.h"
#include "tests/test_places.h"

namespace hrp::test {
namespace {

using ::testing::HasSubstr;

// The walk of figure 9 with another plan.
std::string write_walk(const std::string& name, const std::string& plan) {
  const std::string folder = source_dir() + "/models/scenarios/paper_a/";
  std::ifstream file(folder + "fig9.yaml");
  std::stringstream text;
  text << file.rdbuf();
  std::string scenario = std::regex_replace(text.str(), std::regex("plan: .*"), "plan: " + plan);
  scenario = std::regex_replace(scenario, std::regex("robot: "), "robot: " + folder);
  std::string path = get_test_folder() + "/" + name + ".yaml";
  std::ofstream(path) << scenario;
  return path;
}

// What the set says of it; empty when it walks.
std::string get_refusal(const std::string& name, const std::string& plan) {
  ServerSet set(name, {write_walk(name, plan), "--duration", "0.1"});
  if (set.wait() == 0) return "";
  // A run that is refused before its logger has opened the file has no log and no step either.
  if (std::filesystem::exists(set.log())) {
    EXPECT_LE(find_last_step(set.log()), 0) << name << ": refused before the first step";
  }
  return set.output();
}

TEST(FootstepPlans, ThatLegsCanWalkAreWalked) { EXPECT_EQ(get_refusal("good", "{count: 3, length: 0.2}"), ""); }

TEST(FootstepPlans, TooLongStepsAreRefusedWithTheStepAndTheReason) {
  EXPECT_THAT(get_refusal("long", "{footsteps: [{x: 0.2, y: -0.19}, {x: 0.9, y: 0.19}]}"),
              HasSubstr("step 2 (left): too long: 0.900 m"));
}

TEST(FootstepPlans, CrossingLegsAreRefusedWithTheStepAndTheReason) {
  EXPECT_THAT(get_refusal("crossing", "{footsteps: [{x: 0.2, y: -0.19}, {x: 0.2, y: -0.05}]}"),
              HasSubstr("step 2 (left): crossing legs"));
}

TEST(FootstepPlans, UnknownFramesAreRefusedWithTheStepAndTheName) {
  EXPECT_THAT(get_refusal("frame", "{footsteps: [{frame: map, x: 0.2, y: -0.19}]}"),
              HasSubstr("step 1 (right): unknown frame 'map'"));
}

}  // namespace
}  // namespace hrp::test
