// SPDX-License-Identifier: BSD-3-Clause
#include "controller/ros/ros_controller.h"

#include <gtest/gtest.h>

#include "common/base/diagnostics.h"
#include "tests/unit/ros_commands/trio.h"

namespace hrp {
namespace {

// In the place of one that walks: all joints at 0.1 t, with velocities and no efforts.
class Drifting : public Controller {
 public:
  JointCommand control(const SensorData& sensors, const Robot& robot) override {
    const auto n = static_cast<Eigen::Index>(robot.joints.size());
    return {Eigen::VectorXd::Constant(n, 0.1 * sensors.time), Eigen::VectorXd::Constant(n, 0.1), {}};
  }
};

TEST(RosController, HoldsTheInitialPoseUntilItIsTold) {
  Played played;
  for (int i = 0; i < 10; ++i) EXPECT_EQ(played.step().q, Eigen::VectorXd(Eigen::Vector3d(0.0, 0.2, 0.0)));
}

TEST(RosController, BeginsAtTheLastCommandAndPassesThePointsAtTheirTimesSinceThen) {
  Played played;
  played.play(0.5);
  played.controller.take(make_good_message());
  const JointCommand first = played.step();
  EXPECT_NEAR(first.q[0], make_cubic(0.0, 0.0, 0.5, 0.0, 1.0).find_position(kPeriod), kExact);
  EXPECT_EQ(first.q[1], 0.2);
  EXPECT_NEAR(played.play(1.0 - kPeriod).q[0], 0.5, kExact);
  EXPECT_NEAR(played.play(0.5).q[0], 0.55, kExact);
  EXPECT_NEAR(played.last.q[1], 0.3, kExact);
  EXPECT_NEAR(played.last.qd[1], 1.5 * 0.2, 1e-9);  // rest to rest; times of 1e-13 s times the acceleration
  EXPECT_NEAR(played.play(3.0).q[1], 0.4, kExact);
  EXPECT_EQ(played.last.qd[1], 0.0);
  EXPECT_EQ(played.last.q[2], 0.0);
}

TEST(RosController, ANewMessageGoesOnFromThePresentPositionAndVelocity) {
  Played played;
  played.step();
  played.controller.take(make_good_message());
  const JointCommand before = played.play(0.5);
  ASSERT_NEAR(before.qd[0], 0.75, 1e-9);
  RosJointTrajectory back = make_message({"hip"});
  add_point(1.0, {0.0}, {0.0}, &back);
  played.controller.take(back);
  const CubicSegment expected = make_cubic(before.q[0], before.qd[0], 0.0, 0.0, 1.0);
  EXPECT_NEAR(played.step().q[0], expected.find_position(kPeriod), kExact);
  EXPECT_NEAR(played.last.qd[0], expected.find_velocity(kPeriod), kExact);
  EXPECT_EQ(played.play(2.0).q[0], 0.0);
  EXPECT_EQ(played.last.q[1], before.q[1]);  // the old message is no longer followed
}

TEST(RosController, PositionsOnlyAreFollowedOnStraightLines) {
  Played played;
  played.step();
  RosJointTrajectory message = make_message({"slide"});
  add_point(2.0, {4.0}, {}, &message);
  played.controller.take(message);
  EXPECT_NEAR(played.play(0.5).q[2], 1.0, kExact);
  EXPECT_NEAR(played.last.qd[2], 2.0, kExact);
  EXPECT_EQ(played.last.q[1], 0.2);
}

TEST(RosController, EffortsAreFedForwardOnStraightLinesAndKept) {
  Played played;
  played.step();
  RosJointTrajectory message = make_message({"knee"});
  add_point(1.0, {0.2}, {}, &message);
  message.points()[0].effort({4.0});
  played.controller.take(message);
  EXPECT_NEAR(played.play(0.5).effort[1], 2.0, kExact);
  EXPECT_EQ(played.play(1.0).effort[1], 4.0);
  RosJointTrajectory other = make_message({"hip"});
  add_point(1.0, {0.1}, {}, &other);
  played.controller.take(other);
  EXPECT_EQ(played.play(0.5).effort[1], 4.0);
  EXPECT_EQ(played.last.effort[0], 0.0);
}

TEST(RosController, AFirstPointAtTimeZeroIsWhereTheTrajectoryBegins) {
  Played played;
  played.step();
  RosJointTrajectory message = make_message({"hip"});
  add_point(0.0, {0.5}, {}, &message);
  add_point(1.0, {0.7}, {}, &message);
  played.controller.take(message);
  EXPECT_NEAR(played.step().q[0], 0.5 + 0.2 * kPeriod, kExact);
}

TEST(RosController, AMessageWithoutPointsStopsAllJointsWhereTheyAre) {
  Played played;
  played.step();
  played.controller.take(make_good_message());
  const JointCommand before = played.play(0.5);
  played.controller.take(RosJointTrajectory{});
  EXPECT_EQ(played.step().q, before.q);
  EXPECT_TRUE(played.last.qd.isZero(0.0));
  EXPECT_EQ(played.play(2.0).q, before.q);
}

TEST(RosController, PositionCommandsHoldFromTheNextSampleOn) {
  Played played;
  played.step();
  played.controller.take(make_good_message());
  played.play(0.5);
  RosPositions message;
  message.data({-0.5, 0.25, 7.0});
  played.controller.take(message);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(played.step().q, Eigen::VectorXd(Eigen::Vector3d(-0.5, 0.25, 7.0)));
    EXPECT_TRUE(played.last.qd.isZero(0.0));
  }
}

TEST(RosController, JointsThatNoMessageHasNamedFollowTheOtherController) {
  Robot robot = make_trio();
  robot.settings.type = "walk";
  Played played(robot, std::make_unique<Drifting>());
  played.play(1.0);
  const JointCommand before = played.step();
  EXPECT_NEAR(before.q[1], 0.1, kExact);
  RosJointTrajectory message = make_message({"knee"});
  add_point(1.0, {0.5}, {0.0}, &message);
  played.controller.take(message);
  played.step();
  // From where the other controller had it, with the velocity that it had told.
  EXPECT_NEAR(played.last.q[1], make_cubic(0.1, 0.1, 0.5, 0.0, 1.0).find_position(kPeriod), kExact);
  EXPECT_NEAR(played.last.q[0], 0.1 * (1.0 + kPeriod), kExact);
  played.play(2.0);
  EXPECT_EQ(played.last.q[1], 0.5);
  EXPECT_NEAR(played.last.q[0], 0.1 * (3.0 + kPeriod), kExact);
  EXPECT_NEAR(played.last.qd[0], 0.1, kExact);
  // The knee stays where it was told to be when another joint is named.
  RosJointTrajectory other = make_message({"hip"});
  add_point(1.0, {0.4}, {}, &other);
  played.controller.take(other);
  played.play(1.5);
  EXPECT_EQ(played.last.q[1], 0.5);
  EXPECT_EQ(played.last.q[0], 0.4);
  EXPECT_NEAR(played.last.q[2], 0.1 * (4.5 + kPeriod), kExact);
}

TEST(RosController, OneThatJoinsAWalkLeavesItToTheOtherController) {
  Robot robot = make_trio();
  robot.settings.type = "walk";
  Played played(robot, std::make_unique<Drifting>());
  played.restart(1000);
  EXPECT_NEAR(played.step().q[0], 0.5, kExact);
}

TEST(RosController, AResetForgetsTheMessageAndGoesToTheInitialPose) {
  Played played;
  played.step();
  played.controller.take(make_good_message());
  played.play(1.0);
  played.restart(0);
  EXPECT_EQ(played.play(1.0).q, Eigen::VectorXd(Eigen::Vector3d(0.0, 0.2, 0.0)));
}

TEST(RosController, AMessageBeforeTheFirstSampleBeginsWithIt) {
  Played played;
  played.controller.take(make_good_message());
  played.restart(0);
  EXPECT_EQ(played.step().q[0], 0.0);
  EXPECT_NEAR(played.play(1.0).q[0], 0.5, kExact);
}

TEST(RosController, OneThatJoinsARunThatGoesOnHoldsTheMeasuredPose) {
  Played played;
  played.restart(1000);
  EXPECT_EQ(played.step().q, played.measured);
  const Eigen::VectorXd first = played.measured;
  played.measured.setOnes();
  EXPECT_EQ(played.step().q, first);
}

TEST(RosController, AMessageBeforeItJoinsMovesItsJointsFromTheMeasuredPose) {
  Played played;
  played.controller.take(make_good_message());
  played.restart(1000);
  EXPECT_EQ(played.step().q, played.measured);
  EXPECT_NEAR(played.play(1.0).q[0], 0.5, kExact);
  EXPECT_EQ(played.last.q[2], played.measured[2]) << "no message named it";
  EXPECT_TRUE(played.controller.take_refused().empty());
}

// From the initial pose the hip needs 1.35 rad/s, from where it is 2.7; it may turn at 2.
TEST(RosController, AMessageThatCannotBeFromTheMeasuredPoseIsRefused) {
  Played played;
  RosJointTrajectory message = make_message({"hip"});
  add_point(1.0, {0.9}, {0.0}, &message);
  played.controller.take(message);
  played.measured[0] = -0.9;
  played.restart(1000);
  EXPECT_EQ(played.step().q, played.measured);
  const std::vector<std::string> refused = played.controller.take_refused();
  ASSERT_EQ(refused.size(), 1u);
  EXPECT_NE(refused[0].find("on the way there joint 'hip' reaches"), std::string::npos) << refused[0];
  EXPECT_TRUE(played.controller.take_refused().empty());
}

TEST(RosController, AFloodBeforeTheFirstSampleIsRefused) {
  Played played;
  for (int i = 0; i < 16; ++i) played.controller.take(make_good_message());
  EXPECT_THROW(played.controller.take(make_good_message()), InputError);
}

}  // namespace
}  // namespace hrp
