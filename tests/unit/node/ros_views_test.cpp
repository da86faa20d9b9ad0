// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/ros_views.h"

#include <cmath>

#include <gtest/gtest.h>

#include "common/bus/memory/memory_bus.h"
#include "common/messages/ros_topics.h"

namespace hrp {
namespace {

using Stamp = builtin_interfaces::msg::dds_::Time_;

Mover make_arm(const std::string& name) {
  Mover robot;
  robot.name = name;
  TreeSpec& tree = robot.robot.tree;
  tree.links.resize(2);
  tree.links[0].name = "base";
  tree.links[1].name = "arm";
  tree.links[1].parent = 0;
  tree.links[1].joint.name = "elbow";
  return robot;
}

msg::SensorData make_sensors(double time, double elbow) {
  msg::SensorData sensors;
  sensors.header().time(time);
  sensors.positions({elbow});
  sensors.velocities({0.0});
  sensors.efforts({0.0});
  return sensors;
}

// Times [ms] at which messages of each topic came, of a run of one joint with control periods of 5 ms.
class RosRate : public testing::Test {
 protected:
  RosRate() {
    robots_ = {make_arm("")};
    state_.q = state_.qd = Eigen::VectorXd::Zero(1);
    read<rosgraph_msgs::msg::dds_::Clock_>(topics::kRosClock, [this](const auto& m) { note(m.clock(), &clock_); });
    read<tf2_msgs::msg::dds_::TFMessage_>(topics::kRosTf,
                                          [this](const auto& m) { note(m.transforms()[0].header().stamp(), &tf_); });
    read<sensor_msgs::msg::dds_::JointState_>(topics::kRosJointStates,
                                              [this](const auto& m) { note(m.header().stamp(), &joints_); });
  }

  template <typename Message, typename OnMessage>
  void read(const TopicSpec& topic, OnMessage on_message) {
    readers_.push_back(subscribe<Message>(bus_, topic, Delivery::kReliable, on_message));
  }

  static void note(const Stamp& time, std::vector<long>* times) {
    times->push_back(time.sec() * 1000L + time.nanosec() / 1000000);
  }

  void run(RosViews* views, long end_ms) {
    views->update_readers();
    for (long ms = 0; ms < end_ms; ms += 5) {
      const msg::SensorData sensors = make_sensors(static_cast<double>(ms) * 0.001, 0.0);
      views->publish({{&sensors, &state_}});
      bus_.dispatch_all();
    }
  }

  MemoryBus bus_;
  std::vector<Mover> robots_;
  State state_;
  std::vector<long> clock_, tf_, joints_;
  std::vector<std::unique_ptr<Reader>> readers_;
};

TEST_F(RosRate, WithoutOneEveryControlPeriodIsSent) {
  RosViews views(bus_, robots_);
  run(&views, 1000);
  EXPECT_EQ(clock_.size(), 200u);
  EXPECT_EQ(tf_.size(), 200u);
  EXPECT_EQ(joints_.size(), 200u);
}

TEST_F(RosRate, ThinsJointStatesAndFramesOutAndLeavesTheClock) {
  RosViews views(bus_, robots_, 50.0);
  run(&views, 100);
  EXPECT_EQ(joints_, (std::vector<long>{0, 20, 40, 60, 80}));
  EXPECT_EQ(tf_, joints_);
  EXPECT_EQ(clock_.size(), 20u);
}

// 30 a second in periods of 5 ms: the first sample at or after 0, 33.3, 66.7, 100 ms.
TEST_F(RosRate, ThatDoesNotDivideTheControlRateIsMetOnAverage) {
  RosViews views(bus_, robots_, 30.0);
  run(&views, 10000);
  ASSERT_EQ(joints_.size(), 300u);
  EXPECT_EQ(joints_[1], 35);
  EXPECT_EQ(joints_[2], 70);
  EXPECT_EQ(joints_[3], 100);
}

TEST_F(RosRate, BeyondTheControlRateIsTheControlRate) {
  RosViews views(bus_, robots_, 1000.0);
  run(&views, 1000);
  EXPECT_EQ(joints_.size(), 200u);
}

TEST_F(RosRate, GoesOnAfterAReset) {
  RosViews views(bus_, robots_, 50.0);
  run(&views, 25);
  run(&views, 25);
  EXPECT_EQ(joints_, (std::vector<long>{0, 20, 0, 20}));
}

// What has come on the topics of an arm and of another one, "partner".
class RosNamespaces : public testing::Test {
 protected:
  RosNamespaces() : robots_{make_arm(""), make_arm("partner")} {
    for (Mover& robot : robots_) {
      robot.robot.urdf = "<robot/> of " + robot.name;
      robot.robot.tree.frames = {{"arm", 1, {}, {}}, {"tool", 1, {}, {}}};
      robot.scenario.sensors.imus.resize(1);
      robot.scenario.sensors.imus[0].name = "chest";
      robot.scenario.sensors.imus[0].link = "base";
      robot.scenario.sensors.wrenches.resize(1);
      robot.scenario.sensors.wrenches[0].name = "hand";
      robot.scenario.sensors.wrenches[0].link = "arm";
      State state;
      state.q = state.qd = Eigen::VectorXd::Zero(1);
      states_.push_back(state);
    }
    states_[1].p_WB = {1.0, 2.0, 3.0};
  }

  template <typename Message>
  std::vector<Message>* keep(const std::string& name) {
    const TopicSpec* known = topics::find_any_topic(name);
    EXPECT_NE(known, nullptr) << name;
    auto kept = std::make_shared<std::vector<Message>>();
    TopicSpec topic = *known;
    topic.name = name;
    readers_.push_back(
        subscribe<Message>(bus_, topic, Delivery::kReliable, [kept](const Message& m) { kept->push_back(m); }));
    kept_.push_back(kept);
    return kept.get();
  }

  void publish_once() {
    RosViews views(bus_, robots_);
    views.update_readers();
    msg::SensorData one = make_sensors(0.005, 0.1), other = make_sensors(0.005, 0.2);
    for (msg::SensorData* sensors : {&one, &other}) {
      sensors->imus().resize(1);
      sensors->wrenches().resize(1);
    }
    views.publish({{&one, &states_[0]}, {&other, &states_[1]}});
    bus_.dispatch_all();
  }

  static std::vector<std::string> list_frames(const tf2_msgs::msg::dds_::TFMessage_& message) {
    std::vector<std::string> frames;
    for (const auto& at : message.transforms()) frames.push_back(at.header().frame_id() + " > " + at.child_frame_id());
    return frames;
  }

  MemoryBus bus_;
  std::vector<Mover> robots_;
  std::vector<State> states_;
  std::vector<std::unique_ptr<Reader>> readers_;
  std::vector<std::shared_ptr<void>> kept_;
};

TEST_F(RosNamespaces, AreThoseOfTheRobots) {
  const auto* one = keep<sensor_msgs::msg::dds_::JointState_>("rt/joint_states");
  const auto* other = keep<sensor_msgs::msg::dds_::JointState_>("rt/partner/joint_states");
  const auto* urdf = keep<std_msgs::msg::dds_::String_>("rt/partner/robot_description");
  publish_once();
  ASSERT_EQ(one->size(), 1u);
  ASSERT_EQ(other->size(), 1u);
  EXPECT_EQ(one->at(0).position(), std::vector<double>{0.1});
  EXPECT_EQ(other->at(0).position(), std::vector<double>{0.2});
  EXPECT_EQ(other->at(0).name(), std::vector<std::string>{"elbow"}) << "joints are named as in the URDF";
  ASSERT_EQ(urdf->size(), 1u);
  EXPECT_EQ(urdf->at(0).data(), "<robot/> of partner");
}

TEST_F(RosNamespaces, StandBeforeTheFramesOfAllOtherRobotsInOneTree) {
  const auto* tf = keep<tf2_msgs::msg::dds_::TFMessage_>("rt/tf");
  const auto* fixed = keep<tf2_msgs::msg::dds_::TFMessage_>("rt/tf_static");
  const auto* imu = keep<sensor_msgs::msg::dds_::Imu_>("rt/partner/imu/chest");
  const auto* hand = keep<geometry_msgs::msg::dds_::WrenchStamped_>("rt/partner/wrench/hand");
  publish_once();
  ASSERT_EQ(tf->size(), 1u);
  using Frames = std::vector<std::string>;
  EXPECT_EQ(list_frames(tf->at(0)),
            (Frames{"world > base", "base > arm", "world > partner/base", "partner/base > partner/arm"}));
  EXPECT_EQ(tf->at(0).transforms()[2].transform().translation().y(), 2.0);
  ASSERT_EQ(fixed->size(), 1u) << "what is kept for late readers is one message";
  EXPECT_EQ(list_frames(fixed->at(0)), (Frames{"arm > tool", "partner/arm > partner/tool"}));
  ASSERT_EQ(imu->size(), 1u);
  EXPECT_EQ(imu->at(0).header().frame_id(), "partner/base");
  ASSERT_EQ(hand->size(), 1u);
  EXPECT_EQ(hand->at(0).header().frame_id(), "partner/arm");
}

TEST_F(RosNamespaces, ShareTheWorldOfAFirstRobotThatHasALinkOfThatName) {
  robots_[0].robot.tree.frames.push_back({"world", 0, {}, {}});
  const auto* tf = keep<tf2_msgs::msg::dds_::TFMessage_>("rt/tf");
  publish_once();
  ASSERT_EQ(tf->size(), 1u);
  EXPECT_EQ(tf->at(0).transforms()[0].header().frame_id(), "simulation_world");
  EXPECT_EQ(tf->at(0).transforms()[2].header().frame_id(), "simulation_world");
}

TEST(TopicNames, OfAnotherRobotAreKnownByThoseOfTheFirst) {
  EXPECT_EQ(topics::find_any_topic("rt/partner/joint_states"), &topics::kRosJointStates);
  EXPECT_EQ(topics::find_any_topic("rt/partner/wrench/left_foot"), &topics::kRosWrench);
  EXPECT_EQ(topics::find_any_topic("rt/partner/joint_trajectory"), &topics::kRosJointTrajectory);
  EXPECT_EQ(topics::find_any_topic("hrp/partner/events"), &topics::kEvents);
  EXPECT_EQ(topics::find_any_topic("rt/partner/clock"), nullptr) << "there is one clock";
  EXPECT_EQ(topics::find_any_topic("hrp/partner/robot_state"), nullptr) << "and one state of all";
}

TEST(TopicNames, WithoutARobotMeanTheFirstOne) {
  const std::vector<std::string> names{"hrp/sensor_data", "hrp/partner/sensor_data", "hrp/walker/sensor_data",
                                       "rt/imu/chest", "rt/partner/imu/chest"};
  using Names = std::vector<std::string>;
  EXPECT_EQ(topics::find_meant_topics("sensor_data", names), Names{"hrp/sensor_data"});
  EXPECT_EQ(topics::find_meant_topics("/imu/chest", names), Names{"rt/imu/chest"});
  EXPECT_EQ(topics::find_meant_topics("partner/sensor_data", names), Names{"hrp/partner/sensor_data"});
  EXPECT_EQ(topics::find_meant_topics("chest", names), (Names{"rt/imu/chest", "rt/partner/imu/chest"}));
}

TEST(RosRateFault, RefusesWhatIsNoRate) {
  for (const double rate : {0.0, 30.0, 1e5}) EXPECT_EQ(find_ros_rate_fault(rate), "");
  for (const double rate : {-1.0, 2e5, HUGE_VAL, std::nan("")}) EXPECT_NE(find_ros_rate_fault(rate), "") << rate;
}

}  // namespace
}  // namespace hrp
