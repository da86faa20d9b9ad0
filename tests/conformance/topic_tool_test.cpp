// SPDX-License-Identifier: BSD-3-Clause
// hrp-topic as people use it: the program itself, on a domain with somebody who publishes contact forces.
#include <cstdio>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/bus/domain.h"
#include "common/bus/make_bus.h"
#include "common/messages/pubsub.h"
#include "common/messages/topics.h"
#include "hrp_idl/dynamics.h"
#include "hrp_idl/ros_views.h"
#include "hrp_idl/scheduling.h"
#include "tests/test_places.h"

namespace hrp {
namespace {

using ::testing::HasSubstr;

class TopicTool : public ::testing::TestWithParam<std::string> {
 protected:
  TopicTool() : claim_(claim_free_domain("topic tool test")) {
    BusOptions options;
    options.domain = claim_.domain();
    options.vendor = GetParam();
    bus_ = make_bus(options);
    writer_ = std::thread([this] { publish(); });
  }

  ~TopicTool() override {
    stop_ = true;
    writer_.join();
  }

  // What the tool prints; with `status` its complaints too.
  std::string run(const std::string& arguments, int* status = nullptr) {
    const std::string command = bin_dir() + "/hrp-topic " + arguments + " --domain " + std::to_string(claim_.domain()) +
                                (status ? " 2>&1" : "");
    FILE* pipe = popen(command.c_str(), "r");
    std::string text;
    char part[4096];
    for (size_t size; (size = fread(part, 1, sizeof(part), pipe)) > 0;) text.append(part, size);
    const int result = pclose(pipe);
    if (status) *status = result;
    return text;
  }

 private:
  void publish() {
    Publisher<msg::ContactForces> forces(*bus_, topics::kContactForces);
    Publisher<msg::RunStatus> status(*bus_, topics::kRunStatus);
    Publisher<::sensor_msgs::msg::dds_::JointState_> joints(*bus_, topics::kRosJointStates);
    TopicSpec foreign{"robot/battery", "vendor::Battery"};
    const auto battery = bus_->make_writer(foreign);
    const auto state = bus_->make_writer({"robot/state", "vendor::State"});
    const auto leg = bus_->make_writer({"leg/state", "vendor::State"});
    msg::RunStatus once;
    once.late("controller");
    status.publish(once);
    msg::ContactForces message;
    message.pairs().resize(1);
    message.pairs()[0].name_a("left_foot");
    for (uint64_t step = 0; !stop_; ++step) {
      message.header().step(step);
      message.pairs()[0].total().force().z(412.5);
      forces.publish(message);
      joints.publish({});
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  DomainClaim claim_;
  std::unique_ptr<Bus> bus_;
  std::thread writer_;
  std::atomic<bool> stop_{false};
};

TEST_P(TopicTool, ListsTopicsWithTypesAndRates) {
  const std::string text = run("list --json --seconds 1.5");
  std::map<std::string, nlohmann::json> topics;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const auto json = nlohmann::json::parse(line);
    topics[json["topic"]] = json;
  }
  EXPECT_EQ(topics["hrp/contact_forces"]["type"], "hrp::msg::ContactForces");
  EXPECT_EQ(topics["hrp/contact_forces"]["writers"], 1);
  EXPECT_EQ(topics["hrp/contact_forces"]["readers"], 0);
  EXPECT_GT(topics["hrp/contact_forces"]["rate"], 0.0);
  EXPECT_EQ(topics["robot/battery"]["type"], "vendor::Battery");
  EXPECT_THAT(run("list --seconds 0.1"), HasSubstr("RATE"));
}

TEST_P(TopicTool, EchoesTextWithUnits) {
  const std::string text = run("echo hrp/contact_forces --count 2");
  EXPECT_THAT(text, HasSubstr("pairs:\n- body_a: 0\n"));
  EXPECT_THAT(text, HasSubstr("    force [N]:\n      x: 0\n      y: 0\n      z: 412.5\n"));
}

TEST_P(TopicTool, FindsATopicByTheEndOfItsName) {
  EXPECT_THAT(run("echo contact_forces --count 1"), HasSubstr("pairs:"));
  EXPECT_THAT(run("hz joint_states --count 1"), HasSubstr("bytes a sample"));
  EXPECT_THAT(run("type contact_forces"), HasSubstr("struct ContactForces"));
  int status = 0;
  const std::string text = run("echo state --count 1", &status);
  EXPECT_NE(status, 0);
  EXPECT_THAT(text, HasSubstr("'state' may be leg/state, robot/state"));
}

TEST_P(TopicTool, EchoesJsonLines) {
  std::istringstream lines(run("echo hrp/contact_forces --json --count 3"));
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    EXPECT_EQ(nlohmann::json::parse(line)["pairs"][0]["total"]["force"]["z"], 412.5);
  }
  EXPECT_EQ(count, 3);
}

TEST_P(TopicTool, EchoesOneNumberALine) {
  EXPECT_EQ(run("echo hrp/contact_forces --field 'pairs[0].total.force.z' --count 2"), "412.5\n412.5\n");
  EXPECT_EQ(run("echo hrp/contact_forces --field 'pairs[0].total.force.z' --field 'pairs[0].name_a' --count 1"),
            "412.5 \"left_foot\"\n");
  EXPECT_EQ(run("echo hrp/contact_forces --json --field 'pairs[3].clipped' --count 1"),
            "{\"pairs[3].clipped\":null}\n");
}

TEST_P(TopicTool, ShowsTheLastSampleOfALatestTopic) {
  EXPECT_THAT(run("echo hrp/run_status --count 1"), HasSubstr("late: \"controller\""));
}

TEST_P(TopicTool, EchoesRosViews) {
  EXPECT_THAT(run("echo rt/joint_states --count 1"), HasSubstr("header:\n  stamp:\n    sec [s]: 0\n"));
}

TEST_P(TopicTool, SaysWhatIsWrong) {
  int status = 0;
  EXPECT_THAT(run("echo hrp/contact_forces --field pairs[0].totl --count 1", &status), HasSubstr("'total'"));
  EXPECT_NE(status, 0);
  EXPECT_THAT(run("echo robot/battery --count 1", &status), HasSubstr("vendor::Battery, which is not in our IDL"));
  EXPECT_THAT(run("type NoSuchType", &status), HasSubstr("hrp::msg::ContactForces"));
  EXPECT_THAT(run("type ContactForces"), HasSubstr("// [m/s] tangential velocity"));
}

INSTANTIATE_TEST_SUITE_P(Vendors, TopicTool, ::testing::Values("cyclone", "fast"),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace hrp
