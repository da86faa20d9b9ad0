// SPDX-License-Identifier: BSD-3-Clause
// Scenarios, robots and words on the command line that cannot be used: what is said of them, once, before any step.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/process/run_and_digest.h"
#include "tests/test_places.h"

namespace hrp::test {
namespace {

using ::testing::HasSubstr;

TEST(BadInput, AScenarioIsRefusedWithFileLineKeyAndValue) {
  ScenarioChange change;
  change.steps = "{time_step: -0.001, control_period: 0.005}";
  ServerSet set("bad", {write_scenario("bad", change)});
  EXPECT_EQ(set.wait(), 2);
  EXPECT_THAT(set.output(), HasSubstr("bad.yaml:"));
  EXPECT_THAT(set.output(), HasSubstr("time_step"));
  EXPECT_THAT(set.output(), HasSubstr("-0.001"));
}

TEST(BadInput, ARobotIsRefusedWithFileAndElement) {
  const std::string urdf = get_test_folder() + "/bad.urdf";
  std::ofstream(urdf)
      << "<robot name=\"bad\">\n  <link name=\"base\">\n    <inertial><mass value=\"-1\"/>"
         "<inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>\n  </link>\n</robot>\n";
  const std::string scenario = get_test_folder() + "/bad_robot.yaml";
  std::ofstream(scenario) << "robot: " << urdf << "\nservo: {default: {kp: 1, kd: 0}}\n";
  ServerSet set("bad-robot", {scenario});
  EXPECT_EQ(set.wait(), 2);
  EXPECT_THAT(set.output(), HasSubstr("bad.urdf:"));
  EXPECT_THAT(set.output(), HasSubstr("base"));
}

TEST(BadInput, ARefusalIsSaidOnceHoweverManyServersHearOfIt) {
  const std::string urdf = get_test_folder() + "/twice.urdf";
  std::ofstream(urdf)
      << "<robot name=\"bad\"><link name=\"base\"><inertial><mass value=\"-1\"/></inertial></link></robot>\n";
  const std::string scenario = get_test_folder() + "/twice.yaml";
  std::ofstream(scenario) << "robot: " << urdf << "\nservo: {default: {kp: 1, kd: 0}}\n";
  ServerSet set("twice", {scenario});
  EXPECT_EQ(set.wait(), 2);
  EXPECT_EQ(count(set.output(), "value is negative"), 1) << set.output();
}

struct BadWords {
  std::vector<std::string> words;
  const char* said;
};
void PrintTo(const BadWords& bad, std::ostream* out) { *out << bad.said; }
class CommandLine : public ::testing::TestWithParam<BadWords> {};

TEST_P(CommandLine, ThatNobodyCanMeanIsRefusedAtOnce) {
  std::vector<std::string> words = GetParam().words;
  if (words[0] == "hrp-simulate") words.push_back(write_scenario("meant"));
  Program program(words);
  EXPECT_NE(program.wait(), 0) << program.output();
  EXPECT_THAT(program.output(), HasSubstr(GetParam().said));
  EXPECT_THAT(program.output(), ::testing::Not(HasSubstr("state hash")));
}

INSTANTIATE_TEST_SUITE_P(
    Words, CommandLine,
    ::testing::Values(BadWords{{"hrp-simulate", "--duration", "-1"}, "duration is -1 s, expected"},
                      BadWords{{"hrp-simulate", "--duration", "nan"}, "duration is nan s, expected"},
                      BadWords{{"hrp-simulate", "--in-process", "--dds", "fast"}, "excludes --dds"},
                      BadWords{{"hrp-simulate", "--speed", "nan"}, "speed is nan, expected"},
                      BadWords{{"hrp-simulate", "--speed", "-1"}, "speed is -1, expected"},
                      BadWords{{"hrp-scheduler", "--speed", "1e-9"}, "speed is 1e-09, expected"},
                      BadWords{{"hrp-scheduler", "--duration", "-1"}, "duration is -1 s, expected"},
                      BadWords{{"hrp-run", "step", "-5"}, "5"},
                      BadWords{{"hrp-run", "step", "0"}, "N: Value 0 not in range"}));

TEST(BadInput, AnUnknownServerIsRefused) {
  ServerSet set("unknown", {write_scenario("unknown"), "--dds-for", "dynamo=fast"});
  EXPECT_EQ(set.wait(), 2);
  EXPECT_THAT(set.output(), HasSubstr("dynamo"));
}

}  // namespace
}  // namespace hrp::test
