// SPDX-License-Identifier: BSD-3-Clause
// Somebody pushes the robot of a run: the log says what acted when, and a scenario with these pushes repeats the run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/process/run_and_digest.h"

namespace hrp::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const std::string kSlow = "{time_step: 0.001, control_period: 0.005, duration: 1.5}";

struct Answer {
  int status;
  std::string text;
};

Answer ask(const std::vector<std::string>& words) {
  Program program(words);
  const int status = program.wait();
  return {status, program.output()};
}

Answer push(ServerSet& set, const std::vector<std::string>& words) {
  std::vector<std::string> all{"hrp-run", "push", "--domain", std::to_string(set.find_domain())};
  all.insert(all.end(), words.begin(), words.end());
  return ask(all);
}

std::string read(const std::string& path) {
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

class LivePush : public ::testing::TestWithParam<const char*> {};

// States themselves differ: live pushes have no name.
TEST_P(LivePush, IsLoggedAndAScenarioWithItRepeatsTheRunToTheBit) {
  const std::string scenario = write_scenario("pushed", {"{type: hold}", kSlow});
  std::string log;
  const auto during = [&](ServerSet& set) {
    log = set.log();
    ASSERT_TRUE(set.wait_for_step(50)) << set.output();
    Answer answer =
        push(set, {"WAIST_P_LINK", "--force", "30", "-12.5", "0", "--at", "0", "0.1", "0.2", "--steps", "200"});
    EXPECT_EQ(answer.status, 0) << answer.text;
    answer = push(set, {"R_ELBOW_LINK", "--force", "0", "0", "9.1", "--steps", "40"});
    EXPECT_EQ(answer.status, 0) << answer.text;
    // Refused, and the run goes on.
    EXPECT_THAT(push(set, {"TAIL", "--force", "1", "0", "0"}).text, HasSubstr("no link 'TAIL'"));
    EXPECT_THAT(push(set, {"WAIST_P_LINK", "--force", "1e7", "0", "0"}).text, HasSubstr("more than"));
  };
  auto live = run_and_digest("pushed", scenario, {"--dds", GetParam(), "--speed", "0.3"}, during);
  const Answer pushes = ask({"hrp-log", "pushes", log});
  EXPECT_EQ(pushes.status, 0) << pushes.text;
  EXPECT_THAT(pushes.text, HasSubstr("WAIST_P_LINK"));
  EXPECT_THAT(pushes.text, HasSubstr("force: [30, -12.5, 0]"));
  const std::string repeated = get_test_folder() + "/repeated.yaml";
  std::ofstream(repeated) << read(scenario) << pushes.text;
  auto again = run_and_digest("repeated", repeated, {"--in-process"});
  auto unpushed = run_and_digest("unpushed", scenario, {"--in-process"});
  for (const char* topic : {"hrp/contact_forces", "hrp/contact_set", "hrp/sensor_data", "hrp/joint_commands"}) {
    EXPECT_EQ(live[topic], again[topic]) << topic << "\n" << pushes.text;
  }
  EXPECT_FALSE(live["hrp/sensor_data"] == unpushed["hrp/sensor_data"]);
}
INSTANTIATE_TEST_SUITE_P(Vendors, LivePush, ::testing::Values("cyclone", "fast"));

TEST(LivePush, OnAnObjectRepeatsToTheBit) {
  const std::string scenario = write_scenario("others", {"{type: hold}", kSlow});
  std::ofstream(scenario, std::ios::app)
      << "objects: {crate: {size: [0.2, 0.2, 0.2], mass: 3, position: [1.5, 0, 0.1]}}\n";
  std::string log;
  auto live = run_and_digest("others", scenario, {"--dds", "cyclone", "--speed", "0.3"}, [&](ServerSet& set) {
    log = set.log();
    ASSERT_TRUE(set.wait_for_step(50)) << set.output();
    const Answer answer = push(set, {"crate", "--force", "0", "40", "0", "--steps", "200"});
    EXPECT_EQ(answer.status, 0) << answer.text;
    EXPECT_THAT(push(set, {"crate/lid", "--force", "1", "0", "0"}).text, HasSubstr("ROBOT/LINK"));
  });
  const Answer pushes = ask({"hrp-log", "pushes", log});
  EXPECT_THAT(pushes.text, HasSubstr("link: crate"));
  const std::string repeated = get_test_folder() + "/others_again.yaml";
  std::ofstream(repeated) << read(scenario) << pushes.text;
  auto again = run_and_digest("others_again", repeated, {"--in-process"});
  EXPECT_EQ(live["hrp/contact_forces"], again["hrp/contact_forces"]) << pushes.text;
}

TEST(LivePush, OfNobodyIsNothing) {
  const std::string scenario = write_scenario("quiet");
  ServerSet set("quiet", {scenario, "--in-process", "--force"});
  ASSERT_EQ(set.wait(), 0) << set.output();
  const Answer pushes = ask({"hrp-log", "pushes", set.log()});
  EXPECT_EQ(pushes.status, 0);
  EXPECT_THAT(pushes.text, HasSubstr("nobody pushed"));
}

// The command line refuses what is no force before it looks for a run.
TEST(LivePush, WithoutAForceIsRefusedAtOnce) {
  EXPECT_EQ(ask({"hrp-run", "push", "WAIST_P_LINK"}).status, 2);
  EXPECT_EQ(ask({"hrp-run", "push", "WAIST_P_LINK", "--force", "1", "2"}).status, 2);
}

}  // namespace
}  // namespace hrp::test
