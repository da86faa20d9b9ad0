// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/fall_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hrp {
namespace {

using ::testing::HasSubstr;

// Base, foot and hand; 0.8 m high at the start.
class FallWatchTest : public ::testing::Test {
 protected:
  FallWatchTest() : watch_(make_robot(), Scenario()) { watch_.reset(Eigen::Quaterniond::Identity(), {0, 0, 0.8}); }
  static RobotDescription make_robot() {
    RobotDescription robot;
    for (const char* name : {"base", "foot", "hand"}) {
      LinkSpec link;
      link.name = name;
      link.parent = robot.tree.links.empty() ? -1 : 0;
      robot.tree.links.push_back(link);
    }
    robot.tree.floating_base = true;
    CollisionShape sole;
    sole.link = 1;
    sole.sole = true;
    robot.shapes.push_back(sole);
    return robot;
  }
  static ContactForces touch(const std::vector<int>& links) {
    ContactForces forces;
    for (int link : links) {
      PairForce pair;
      pair.body_a = link;
      pair.total[5] = 100.0;  // [N]
      forces.push_back(pair);
    }
    return forces;
  }
  std::optional<FallEvent> look(double tilt, double height, const std::vector<int>& links) {
    const Eigen::Quaterniond R(Eigen::AngleAxisd(tilt * M_PI / 180, Vector3d::UnitY()));
    if (!watch_.is_due(R, {0, 0, height})) return std::nullopt;
    return watch_.update(touch(links));
  }
  FallWatch watch_;
};

TEST_F(FallWatchTest, StandingAndSquattingOnFeetIsNoFall) {
  for (double height : {0.8, 0.7, 0.5, 0.3}) EXPECT_FALSE(look(5, height, {1})) << height;
  EXPECT_FALSE(look(40, 0.7, {1})) << "leaning far, on its feet";
}

TEST_F(FallWatchTest, ABaseThatLiesOnItsSideHasFallenWhateverTouches) {
  const auto event = look(75, 0.6, {});
  ASSERT_TRUE(event && event->fall);
  EXPECT_THAT(event->text, HasSubstr("tilted by 75 deg, 0.60 m above the ground (0.80 m at the start)"));
}

TEST_F(FallWatchTest, ABaseThatSinksThroughTheGroundHasFallen) {
  const auto event = look(0, -1.0, {});
  EXPECT_TRUE(event && event->fall);
}

TEST_F(FallWatchTest, AHandOnTheGroundIsAFallOnlyWhenTheBaseIsTiltedOrLow) {
  const auto kneeling = look(20, 0.5, {1, 2});
  ASSERT_TRUE(kneeling);
  EXPECT_FALSE(kneeling->fall);
  EXPECT_THAT(kneeling->text, HasSubstr("hand touches the ground"));
  const auto fallen = look(35, 0.5, {1, 2});
  ASSERT_TRUE(fallen && fallen->fall);
  EXPECT_EQ(fallen->links, std::vector<std::string>{"hand"});
}

TEST_F(FallWatchTest, EachIsSaidOnceInAnEpoch) {
  EXPECT_TRUE(look(90, 0.2, {0}));
  EXPECT_FALSE(look(91, 0.2, {0}));
  const auto touch = look(92, 0.2, {0, 2});
  ASSERT_TRUE(touch) << "a link more";
  EXPECT_FALSE(touch->fall);
  watch_.reset(Eigen::Quaterniond::Identity(), {0, 0, 0.8});
  EXPECT_TRUE(look(90, 0.2, {0}));
}

}  // namespace
}  // namespace hrp
