// SPDX-License-Identifier: BSD-3-Clause
// A run in one process starts and ends as the server set's.
#include <gtest/gtest.h>

#include "common/base/read_file.h"
#include "common/robot/yaml_sections.h"
#include "servers/console/trial/trial.h"
#include "servers/model_parser/robot_loader.h"
#include "tests/test_places.h"

namespace hrp {
namespace {

Scenario parse(const std::string& yaml) { return parse_scenario(yaml, source_dir() + "/models/scenarios/test.yaml"); }

TrialResult run(const std::string& yaml) { return Trial(parse(yaml)).run(); }

constexpr const char* kShort = "steps: {time_step: 0.001, control_period: 0.005, duration: 0.2}\n";

TEST(TrialFall, OfARobotOnAFixedBaseIsNone) {
  const std::string arm = "robot: ../test_robots/arm.urdf\nbase: fixed\nservo: {default: {kp: 100, kd: 5}}\n";
  const TrialResult hung = run(arm + "initial: {rpy: [3.14159, 0, 0]}\n" + kShort),
                    below = run(arm + "initial: {position: [0, 0, -0.5]}\n" + kShort);
  EXPECT_FALSE(hung.fallen);
  EXPECT_FALSE(below.fallen);
  EXPECT_NEAR(hung.duration, 0.2, 1e-9);
  EXPECT_NEAR(below.duration, 0.2, 1e-9);
}

TEST(TrialFall, OfAHumanoidWithoutStiffServosIsOne) {
  const std::string text = read_input(source_dir() + "/models/scenarios/squat.yaml");
  std::string limp;
  for (const YamlSection& section : split_sections(text)) {
    if (section.key != "servo" && section.key != "steps") limp += section.text;
  }
  const TrialResult result = run(limp +
                                 "\nservo: {default: {kp: 1, kd: 0.1}}\nsteps: {time_step: 0.001, "
                                 "control_period: 0.005, duration: 4}\n");
  EXPECT_TRUE(result.fallen);
  EXPECT_LT(result.fall_time, 2.0) << "a body of 0.8 m height falls in less than one second";
}

// Its first frame is half-sitting. From straight legs the servos would throw the robot up.
TEST(TrialStart, OfAMotionIsItsFirstFrameAsInTheServerSet) {
  const std::string text = read_input(source_dir() + "/models/scenarios/squat.yaml");
  std::string bare;
  for (const YamlSection& section : split_sections(text)) {
    if (section.key != "initial") bare += section.text;
  }
  const Scenario scenario = parse(bare);
  const Scenario of_servers = parse(load_robot(scenario).scenario);
  ASSERT_NEAR(of_servers.initial_joints.at("R_KNEE"), 0.87, 0.01);
  const Trial trial(scenario);
  EXPECT_EQ(trial.scenario().initial_joints, of_servers.initial_joints);
}

}  // namespace
}  // namespace hrp
