// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/ros_views.h"

#include <cmath>

#include <gtest/gtest.h>

#include "common/bus/memory/memory_bus.h"
#include "common/messages/ros_topics.h"

namespace hrp {
namespace {

using Stamp = builtin_interfaces::msg::dds_::Time_;

// Times [ms] at which messages of each topic came, of a run of one joint with control periods of 5 ms.
class RosRate : public testing::Test {
 protected:
  RosRate() {
    robot_.tree.links.resize(2);
    robot_.tree.links[0].name = "base";
    robot_.tree.links[1].name = "arm";
    robot_.tree.links[1].parent = 0;
    robot_.tree.links[1].joint.name = "elbow";
    state_.q = state_.qd = Eigen::VectorXd::Zero(1);
    read<rosgraph_msgs::msg::dds_::Clock_>(topics::kRosClock, [this](const auto& m) { note(m.clock(), &clock_); });
    read<tf2_msgs::msg::dds_::TFMessage_>(topics::kRosTf, [this](const auto& m) { note(m.transforms()[0].header().stamp(), &tf_); });
    read<sensor_msgs::msg::dds_::JointState_>(topics::kRosJointStates, [this](const auto& m) { note(m.header().stamp(), &joints_); });
  }

  template <typename Message, typename OnMessage>
  void read(const TopicSpec& topic, OnMessage on_message) {
    readers_.push_back(subscribe<Message>(bus_, topic, Delivery::kReliable, on_message));
  }

  static void note(const Stamp& time, std::vector<long>* times) { times->push_back(time.sec() * 1000L + time.nanosec() / 1000000); }

  void run(RosViews* views, long end_ms) {
    views->update_readers();
    msg::SensorData sensors;
    sensors.positions({0.0});
    sensors.velocities({0.0});
    sensors.efforts({0.0});
    for (long ms = 0; ms < end_ms; ms += 5) {
      sensors.header().time(static_cast<double>(ms) * 0.001);
      views->publish(sensors, state_);
      bus_.dispatch_all();
    }
  }

  MemoryBus bus_;
  RobotDescription robot_;
  State state_;
  std::vector<long> clock_, tf_, joints_;
  std::vector<std::unique_ptr<Reader>> readers_;
};

TEST_F(RosRate, WithoutOneEveryControlPeriodIsSent) {
  RosViews views(bus_, robot_, {});
  run(&views, 1000);
  EXPECT_EQ(clock_.size(), 200u);
  EXPECT_EQ(tf_.size(), 200u);
  EXPECT_EQ(joints_.size(), 200u);
}

TEST_F(RosRate, ThinsJointStatesAndFramesOutAndLeavesTheClock) {
  RosViews views(bus_, robot_, {}, 50.0);
  run(&views, 100);
  EXPECT_EQ(joints_, (std::vector<long>{0, 20, 40, 60, 80}));
  EXPECT_EQ(tf_, joints_);
  EXPECT_EQ(clock_.size(), 20u);
}

// 30 a second in periods of 5 ms: the first sample at or after 0, 33.3, 66.7, 100 ms.
TEST_F(RosRate, ThatDoesNotDivideTheControlRateIsMetOnAverage) {
  RosViews views(bus_, robot_, {}, 30.0);
  run(&views, 10000);
  ASSERT_EQ(joints_.size(), 300u);
  EXPECT_EQ(joints_[1], 35);
  EXPECT_EQ(joints_[2], 70);
  EXPECT_EQ(joints_[3], 100);
}

TEST_F(RosRate, BeyondTheControlRateIsTheControlRate) {
  RosViews views(bus_, robot_, {}, 1000.0);
  run(&views, 1000);
  EXPECT_EQ(joints_.size(), 200u);
}

TEST_F(RosRate, GoesOnAfterAReset) {
  RosViews views(bus_, robot_, {}, 50.0);
  run(&views, 25);
  run(&views, 25);
  EXPECT_EQ(joints_, (std::vector<long>{0, 20, 0, 20}));
}

TEST(RosRateFault, RefusesWhatIsNoRate) {
  for (const double rate : {0.0, 30.0, 1e5}) EXPECT_EQ(find_ros_rate_fault(rate), "");
  for (const double rate : {-1.0, 2e5, HUGE_VAL, std::nan("")}) EXPECT_NE(find_ros_rate_fault(rate), "") << rate;
}

}  // namespace
}  // namespace hrp
