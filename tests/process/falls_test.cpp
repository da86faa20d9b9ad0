// SPDX-License-Identifier: BSD-3-Clause
// A robot whose drives do nothing collapses: that is said before and when it happens, and it lies on the ground.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <regex>

#include "common/mcap/reader.h"
#include "common/messages/topics.h"
#include "hrp_idl/dynamics.h"
#include "servers/viewer/recording.h"
#include "tests/process/server_set.h"

namespace hrp::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::string write_limp() {
  ScenarioChange change;
  change.steps = "{time_step: 0.001, control_period: 0.005, duration: 2}";
  std::string path = write_scenario("limp", change);
  std::ifstream file(path);
  std::string text((std::istreambuf_iterator<char>(file)), {});
  text = std::regex_replace(text, std::regex("\nservo:(\n .*)*"), "");
  std::ofstream(path) << text;
  return path;
}

msg::RobotState read_last_state(const std::string& log) {
  msg::RobotState state;
  mcap::Reader(log).read_messages(
      [&](const mcap::Message& message) {
        decode({message.data, message.size}, &state);
        return true;
      },
      {topics::kRobotState.name});
  return state;
}

TEST(Fall, IsSaidLoggedAndEndsOnTheGroundAlikeInOneProcessAndSix) {
  const std::string scenario = write_limp();
  ServerSet one("one", {scenario, "--in-process"}), six("six", {scenario});
  for (ServerSet* set : {&one, &six}) {
    EXPECT_EQ(set->wait(), 0) << set->output();
    EXPECT_THAT(set->output(), HasSubstr("no servo gains: joints are free"));
    EXPECT_THAT(set->output(), HasSubstr("dynamics: t = 0."));
    EXPECT_THAT(set->output(), HasSubstr("\nfall       t = 0."));
    EXPECT_THAT(set->output(), HasSubstr("the robot has fallen: base tilted by"));
    EXPECT_THAT(set->output(), HasSubstr("on the ground: "));
    EXPECT_GT(read_last_state(set->log()).X_WB().translation().z(), 0.0)
        << "a base 0.1 m thick lies on the ground, not under it";
  }
  EXPECT_THAT(read_log(six.log())->notes(), ::testing::Contains(HasSubstr("fell at t = 0.")))
      << "what the page lists of a recording";
  const auto events = digest_log(one.log());
  ASSERT_GT(events.at(topics::kEvents.name).count, 0u);
  EXPECT_EQ(events, digest_log(six.log()));
}

TEST(Fall, OfARobotThatStandsNothingIsSaidOrLogged) {
  ServerSet set("stands", {write_scenario("stands"), "--in-process"});
  EXPECT_EQ(set.wait(), 0) << set.output();
  EXPECT_THAT(set.output(), Not(HasSubstr("fall")));
  EXPECT_THAT(set.output(), Not(HasSubstr("no servo gains")));
  EXPECT_EQ(digest_log(set.log()).count(topics::kEvents.name), 0u) << "the log is what it was without events";
}

TEST(BlowUp, IsSaidOnceWithJointTimeAndLikelyReason) {
  const std::string path = write_scenario("kicked");
  std::ofstream(path, std::ios::app)
      << "\npushes: {kick: {link: R_HAND_LINK, force: [1.0e12, 0, 1.0e12], start: 0.1, duration: 1}}\n";
  ServerSet set("kicked", {path, "--quiet"});
  EXPECT_EQ(set.wait(), 1) << set.output();
  EXPECT_EQ(count(set.output(), "the state blows up at t = 0.10"), 1) << set.output();
  EXPECT_THAT(set.output(), HasSubstr("joint '"));
  EXPECT_THAT(set.output(), HasSubstr("likely reason: the push 'kick'"));
  EXPECT_GE(find_last_step(set.log()), 100) << "the log is complete up to there";
}

}  // namespace
}  // namespace hrp::test
