// SPDX-License-Identifier: BSD-3-Clause
// A joint of a leg that counts the other way, in our biped and in other people's walks.
#include "diagnosis/floating/conventions/turned_legs.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/test_places.h"
#include "tests/unit/diagnosis/legged/biped.h"

namespace hrp::diagnosis::floating {
namespace {

Experiment turn(const Experiment& e, const std::string& joint) {
  return convert_turned_legs(e, {{e.robot.tree.find_joint(joint)}, 1.0});
}

TEST(TurnedLegs, FeetThatStandInTheWorldTellWhichJointCountsTheOtherWay) {
  Recorded recorded = kLeans;
  recorded.pose = true;
  const Experiment e = make_biped({}, recorded);
  EXPECT_TRUE(find_turned_legs(e).joints.empty());
  for (int j = 0; j < e.num_joints(); ++j) {
    const TurnedJoints found = find_turned_legs(convert_turned_legs(e, {{j}, 1.0}));
    ASSERT_EQ(found.joints, std::vector<int>{j}) << e.robot.tree.joint(j).name;
    EXPECT_LT(found.left, 0.25);
  }
}

// Both legs of this biped do the same. Two feet alone cannot tell a left joint from the right one.
TEST(TurnedLegs, TwoExplanationsThatAreAsGoodAreNotChosenFrom) {
  const Experiment e = make_biped({}, kLeans);
  EXPECT_TRUE(find_turned_legs(turn(e, "l_hip")).joints.empty());
}

TEST(TurnedLegs, SoftAndLooseJointsAreNotTurned) {
  Hidden hidden;
  hidden.give = 0.002;
  hidden.slope = 0.05;
  hidden.load = 5.0;
  EXPECT_TRUE(find_turned_legs(make_biped(hidden, kLeans)).joints.empty());
}

class TurnedLegsOf : public testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(TurnedLegsOf, ARealWalkAreFoundAndNoOthers) {
  const std::filesystem::path path =
      std::filesystem::path(source_dir()) / "../shared/recordings" / GetParam().first / "experiment.yaml";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there, NOTHING was checked";
  const Experiment e = load_experiment(path.string());
  EXPECT_TRUE(find_turned_legs(e).joints.empty());
  EXPECT_EQ(find_turned_legs(turn(e, GetParam().second)).joints,
            std::vector<int>{e.robot.tree.find_joint(GetParam().second)});
}

INSTANTIATE_TEST_SUITE_P(Recordings, TurnedLegsOf,
                         testing::Values(std::pair{"icub_walking", "r_hip_roll"},
                                         std::pair{"icub_walking", "l_hip_pitch"},
                                         std::pair{"go1_walk", "FL_thigh_joint"},
                                         std::pair{"go1_walk", "FR_thigh_joint"}));

}  // namespace
}  // namespace hrp::diagnosis::floating
