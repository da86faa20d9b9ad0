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
  // As look(), without a plane: the lowest point that is touched is at this height.
  std::optional<FallEvent> look_at(FallWatch* watch, double tilt, double height, const std::vector<int>& links,
                                   double foothold) {
    const Eigen::Quaterniond R(Eigen::AngleAxisd(tilt * M_PI / 180, Vector3d::UnitY()));
    ContactForces forces = touch(links);
    for (PairForce& pair : forces) {
      pair.body_b = make_obstacle_index(0);
      pair.points.resize(1);
      pair.points[0].p_WC.z() = foothold;
    }
    return watch->is_due(R, {0, 0, height}) ? watch->update(forces) : std::nullopt;
  }
  static FallWatch make_on_terrain() {
    Scenario scenario;
    scenario.ground.present = false;
    scenario.obstacles.resize(1);
    FallWatch watch(make_robot(), scenario);
    watch.reset(Eigen::Quaterniond::Identity(), {0, 0, 5.8});
    return watch;
  }
  FallWatch watch_;
};

TEST_F(FallWatchTest, WalkingDownstairsIsNoFallButTheEdgeIs) {
  FallWatch watch = make_on_terrain();
  for (const double foothold : {5.0, 4.0, 3.0})
    EXPECT_FALSE(look_at(&watch, 5, foothold + 0.8, {1}, foothold)) << foothold;
  EXPECT_FALSE(look_at(&watch, 5, 3.7, {}, 0)) << "in the air";
  const auto event = look_at(&watch, 5, 3.1, {}, 0);
  ASSERT_TRUE(event && event->fall) << "0.1 m above where it stood last";
  EXPECT_THAT(event->text, HasSubstr("0.10 m above the ground (0.80 m at the start)"));
}

TEST_F(FallWatchTest, LyingOnTerrainIsAFall) {
  FallWatch watch = make_on_terrain();
  EXPECT_FALSE(look_at(&watch, 0, 5.8, {1}, 5.0));
  EXPECT_FALSE(look_at(&watch, 5, 5.8, {1, 2}, 5.0)) << "a hand on an obstacle, upright";
  const auto event = look_at(&watch, 35, 5.5, {1, 2}, 5.0);
  ASSERT_TRUE(event && event->fall);
  EXPECT_EQ(event->links, std::vector<std::string>{"hand"});
}

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
