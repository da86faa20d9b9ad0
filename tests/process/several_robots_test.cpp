// SPDX-License-Identifier: BSD-3-Clause
// Several robots in the server set: a controller process and topics of its own for each, and the bits of one process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>

#include "common/messages/topics.h"
#include "tests/process/run_and_digest.h"
#include "tests/test_places.h"

namespace hrp::test {
namespace {

using ::testing::HasSubstr;

const std::string kModels = source_dir() + "/models";

// The box of test_robots beside a robot that does squats.
std::string write_world(const std::string& name, const std::string& duration = "0.5") {
  std::string path = get_test_folder() + "/" + name + ".yaml";
  std::ofstream(path) << "robot: " << kModels
                      << "/test_robots/box.urdf\nfeet: [box]\ninitial: {position: [3, 0, 0.1]}\n"
                      << "robots:\n  partner: {scenario: " << kModels << "/scenarios/squat.yaml, yaw: 0.5}\n"
                      << "controller: {type: hold}\nsteps: {duration: " << duration << "}\n";
  return path;
}

void expect_end(const std::string& name, std::vector<std::string> options, int status, const std::string& said) {
  options.insert(options.begin(), write_world(name));
  ServerSet set("robots-" + name, options);
  EXPECT_EQ(set.wait(), status);
  EXPECT_THAT(set.output(), HasSubstr(said));
}

TEST(Robots, HaveTheSameBitsInOneProcessAndInSeven) {
  const auto reference = run_and_digest("robots-one", write_world("robots"), {"--in-process"});
  EXPECT_EQ(reference.at("hrp/robot_state").count, 501u);
  EXPECT_EQ(reference.at("hrp/partner/sensor_data").count, 101u);
  EXPECT_EQ(reference.at("hrp/partner/joint_commands").count, 100u);
  EXPECT_EQ(run_and_digest("robots-cyclone", write_world("robots"), {"--dds", "cyclone"}), reference);
  EXPECT_EQ(run_and_digest("robots-fast", write_world("robots"), {"--dds", "fast"}), reference);
  EXPECT_EQ(run_and_digest("robots-mixed", write_world("robots"), {"--dds-for", "controller.partner=fast"}), reference);
}

TEST(Robots, AControllerOfOnesOwnDrivesOneOfThem) {
  ServerSet set("robots-own", {write_world("own"), "--controller-of", "partner=my-controller"});
  EXPECT_EQ(set.wait(), 0) << set.output();
  EXPECT_EQ(find_last_step(set.log()), 500);
}

TEST(Robots, TheirPlacesAreFilledByTheCommandThatTheRunPrints) {
  ServerSet set("robots-place", {write_world("place"), "--without", "controller.partner"});
  ASSERT_TRUE(wait_until([&] { return set.output().find("--robot partner") != std::string::npos || set.has_ended(); }))
      << set.output();
  EXPECT_THAT(set.output(), HasSubstr("hrp/partner/sensor_data"));
  Program controller({"my-controller", "--run", std::to_string(set.process_id()), "--robot", "partner"});
  EXPECT_EQ(set.wait(), 0) << set.output() << controller.output();
  EXPECT_EQ(controller.wait(), 0) << controller.output();
}

TEST(Robots, TheControllerThatDiesIsNamed) {
  ServerSet set("robots-dies", {write_world("dies", "0"), "--controller-of", "partner=my-controller"});
  ASSERT_TRUE(set.wait_for_step(50)) << set.output();
  kill(set.find_server("my-controller"), SIGKILL);
  EXPECT_EQ(set.wait(), 1);
  EXPECT_THAT(set.output(), HasSubstr("controller.partner (my-controller"));
}

TEST(Robots, ACommandThatCannotBeIsBlamedOnItsController) {
  expect_end("nan", {"--program", "controller.partner=hrp-odd-controller-nan"}, 1, "controller.partner sent NaN");
}

TEST(Robots, ARobotThatIsNotThereIsSaid) {
  expect_end("none", {"--without", "controller.walker"}, 2, "has no robot 'walker', which --without names");
}

// A robot without servos collapses beside the box.
TEST(Robots, TheFallOfOneIsSaidWithItsNameAndLoggedAlikeInOneProcessAndInSeven) {
  const std::string limp = get_test_folder() + "/limp_partner.yaml", world = get_test_folder() + "/fall.yaml";
  std::ofstream(limp)
      << "robot: " << kModels
      << "/hrp2p_like/hrp2p_like.urdf\nfeet: [L_ANKLE_R_LINK, R_ANKLE_R_LINK]\ncontroller: {type: hold}\n";
  std::ofstream(world) << "robot: " << kModels
                       << "/test_robots/box.urdf\nfeet: [box]\ninitial: {position: [3, 0, 0.1]}\n"
                       << "robots: {partner: {scenario: " << limp
                       << "}}\ncontroller: {type: hold}\nsteps: {duration: 1.5}\n";
  ServerSet one("fall-one", {world, "--in-process"}), seven("fall-seven", {world});
  for (ServerSet* set : {&one, &seven}) {
    EXPECT_EQ(set->wait(), 0) << set->output();
    EXPECT_THAT(set->output(), HasSubstr("robot 'partner' has fallen: base"));
    EXPECT_THAT(set->output(), HasSubstr("\nfall       t = "));
  }
  const auto digest = digest_log(one.log());
  ASSERT_EQ(digest.count("hrp/partner/events"), 1u);
  EXPECT_EQ(digest.count("hrp/events"), 0u) << "the box has not fallen";
  EXPECT_EQ(digest, digest_log(seven.log()));
}

TEST(Robots, OneFollowsTheRos2CommandsOfItsNamespace) {
  ServerSet set("robots-ros", {write_world("ros", "0"), "--realtime", "--controller-of", "partner=hrp-controller-ros"});
  ASSERT_TRUE(set.wait_for_step(50)) << set.output();
  const std::string message =
      "{joint_names: [R_ELBOW], points: [{positions: [-1.2], time_from_start: {nanosec: 200000000}}]}";
  Program pub({"hrp-topic", "pub", "partner/joint_trajectory", message, "--run", std::to_string(set.process_id())});
  EXPECT_EQ(pub.wait(), 0) << pub.output();
  std::string echoed;
  EXPECT_TRUE(wait_until([&] {
    Program echo({"hrp-topic", "echo", "hrp/partner/joint_commands", "--count", "1", "--json", "--run",
                  std::to_string(set.process_id())});
    echo.wait();
    echoed = echo.output();
    return echoed.find("-1.2,") != std::string::npos;
  })) << echoed
      << set.output();
  set.send_signal(SIGINT);
  set.wait();
}

TEST(Robots, AnEngineThatSimulatesOneRobotRefuses) {
  ServerSet set("robots-mujoco", {write_world("mujoco"), "--program", "dynamics=hrp-dynamics-mujoco"});
  EXPECT_NE(set.wait(), 0);
  EXPECT_THAT(set.output(), HasSubstr("another robot is not in the MuJoCo dynamics server"));
}

}  // namespace
}  // namespace hrp::test
