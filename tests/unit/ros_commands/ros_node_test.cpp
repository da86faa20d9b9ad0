// SPDX-License-Identifier: BSD-3-Clause
// The node around the controller: topics, lockstep, and what comes before the robot is known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/bus/memory/memory_bus.h"
#include "common/messages/ros_topics.h"
#include "tests/unit/ros_commands/trio.h"

namespace hrp {
namespace {

// The node answers in lockstep; what is no message at all ends no run.
class RosNode : public testing::Test {
 protected:
  RosNode()
      : node_({&bus_, "controller", "hrp-controller-ros", ""}),
        sensors_(bus_, topics::kSensorData),
        ros_(bus_.make_writer(topics::kRosJointTrajectory)) {
    node_.make_endpoints();
    reader_ = subscribe<msg::JointCommands>(bus_, topics::kJointCommands, Delivery::kReliable,
                                            [this](const msg::JointCommands& m) { answers_.push_back(m); });
    status_reader_ = subscribe<msg::ServerStatus>(bus_, topics::kServerStatus, Delivery::kReliable,
                                                  [this](const msg::ServerStatus& m) { said_ = m.message(); });
  }

  void describe() {
    msg::RobotDescription message;
    to_message(make_description(), &message);
    Publisher<msg::RobotDescription>(bus_, topics::kRobotDescription).publish(message);
    bus_.dispatch_all();
  }

  void ask(uint64_t step) {
    msg::SensorData message;
    message.header().step(step);
    message.header().time(0.001 * static_cast<double>(step));
    message.positions({0.0, 0.2, 0.0});
    message.velocities({0.0, 0.0, 0.0});
    message.efforts({0.0, 0.0, 0.0});
    sensors_.publish(message);
    bus_.dispatch_all();
  }

  void tell(const RosJointTrajectory& message) {
    std::vector<char> buffer;
    ros_->write(encode(message, &buffer));
    bus_.dispatch_all();
    node_.on_idle(std::chrono::steady_clock::now());
    bus_.dispatch_all();
  }

  MemoryBus bus_;
  RosControllerNode node_;
  Publisher<msg::SensorData> sensors_;
  std::unique_ptr<Writer> ros_;
  std::unique_ptr<Reader> reader_, status_reader_;
  std::vector<msg::JointCommands> answers_;
  std::string said_;
};

TEST_F(RosNode, AnswersEverySampleWithTheTrajectoryOfItsTime) {
  describe();
  ask(0);
  tell(make_good_message());
  ask(500);
  ask(500);  // repeated, as when an answer was lost
  ask(1000);
  ASSERT_EQ(answers_.size(), 4u);
  EXPECT_EQ(answers_[0].positions(), (std::vector<double>{0.0, 0.2, 0.0}));
  EXPECT_NEAR(answers_[1].positions()[0], 0.25, kExact);
  EXPECT_EQ(answers_[2].positions(), answers_[1].positions());
  EXPECT_EQ(answers_[3].header().step(), 1000u);
  EXPECT_NEAR(answers_[3].positions()[0], 0.5, kExact);
}

TEST_F(RosNode, SaysWhatItRefusesAndGoesOn) {
  describe();
  ask(0);
  RosJointTrajectory message = make_good_message();
  message.joint_names()[0] = "hop";
  tell(message);
  EXPECT_THAT(said_,
              testing::HasSubstr("refused, goes on as before: rt/joint_trajectory: error: joint_names[0]: 'hop'"));
  ask(5);
  EXPECT_EQ(answers_.back().positions(), answers_.front().positions());
  EXPECT_EQ(node_.outcome(), NodeOutcome::kRunning);
}

TEST(RosNodeOfAnotherRobot, FollowsTheTopicsOfItsNamespace) {
  MemoryBus bus;
  NodeContext context{&bus, "controller.partner", "hrp-controller-ros", ""};
  context.robot = "partner";
  RosControllerNode node(context);
  node.make_endpoints();
  std::string said;
  const auto status = subscribe<msg::ServerStatus>(bus, topics::kServerStatus, Delivery::kReliable,
                                                   [&](const msg::ServerStatus& m) { said = m.message(); });
  msg::RobotDescription description;
  to_message(make_description(), &description);
  Publisher<msg::RobotDescription>(bus, topics::of_robot(topics::kRobotDescription, "partner")).publish(description);
  RosJointTrajectory message = make_good_message();
  message.joint_names()[0] = "hop";
  Publisher<RosJointTrajectory> first(bus, topics::kRosJointTrajectory),
      its(bus, topics::of_robot(topics::kRosJointTrajectory, "partner"));
  const auto tell = [&](Publisher<RosJointTrajectory>* publisher) {
    publisher->publish(message);
    bus.dispatch_all();
    node.on_idle(std::chrono::steady_clock::now());
    bus.dispatch_all();
  };
  tell(&first);
  EXPECT_EQ(said, "") << "that of the first robot";
  tell(&its);
  EXPECT_THAT(said, testing::HasSubstr("rt/partner/joint_trajectory: error: joint_names[0]: 'hop'"));
}

TEST_F(RosNode, BytesThatAreNoMessageEndNoRun) {
  describe();
  ask(0);
  const std::vector<uint8_t> garbage(64, 0xff);
  ros_->write({garbage.data(), garbage.size()});
  bus_.dispatch_all();
  node_.on_idle(std::chrono::steady_clock::now());
  bus_.dispatch_all();
  EXPECT_THAT(said_, testing::HasSubstr("rt/joint_trajectory: cannot decode a sample of 64 bytes"));
  ask(5);
  EXPECT_EQ(answers_.size(), 2u);
}

// Whoever starts a run and sends a command at once: the robot does it, even if the node did not know the robot yet.
TEST_F(RosNode, DoesWhatCameBeforeTheRobotWasKnown) {
  tell(make_good_message());
  describe();
  ask(0);
  ask(500);
  ASSERT_EQ(answers_.size(), 2u);
  EXPECT_NEAR(answers_[1].positions()[0], 0.25, kExact);
}

TEST_F(RosNode, RefusesWhatIsWrongOfAnEarlyMessageWhenTheRobotIsKnown) {
  RosJointTrajectory message = make_good_message();
  message.joint_names()[0] = "hop";
  tell(message);
  describe();
  node_.on_idle(std::chrono::steady_clock::now());
  bus_.dispatch_all();
  EXPECT_THAT(said_, testing::HasSubstr("rt/joint_trajectory: error: joint_names[0]: 'hop'"));
}

TEST_F(RosNode, SaysThatTooManyMessagesCameBeforeTheRobotWasKnown) {
  for (int i = 0; i < 17; ++i) tell(make_good_message());
  EXPECT_THAT(said_, testing::HasSubstr(
                         "rt/joint_trajectory: came before the robot was known, after 16 others; send it again"));
}

}  // namespace
}  // namespace hrp
