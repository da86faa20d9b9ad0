// SPDX-License-Identifier: BSD-3-Clause
// SR1 walks its published pattern through the six processes, with nothing given but the robot, its gains and the
// motion.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "common/mcap/reader.h"
#include "common/messages/topics.h"
#include "hrp_idl/dynamics.h"
#include "tests/process/server_set.h"
#include "tests/test_places.h"

namespace hrp::test {
namespace {

// Joints by Choreonoid's joint id.
const char kOrder[] =
    "RLEG_HIP_R, RLEG_HIP_P, RLEG_HIP_Y, RLEG_KNEE, RLEG_ANKLE_P, RLEG_ANKLE_R, RARM_SHOULDER_P, RARM_SHOULDER_R, "
    "RARM_SHOULDER_Y, RARM_ELBOW, RARM_WRIST_Y, RARM_WRIST_P, RARM_WRIST_R, LLEG_HIP_R, LLEG_HIP_P, LLEG_HIP_Y, "
    "LLEG_KNEE, "
    "LLEG_ANKLE_P, LLEG_ANKLE_R, LARM_SHOULDER_P, LARM_SHOULDER_R, LARM_SHOULDER_Y, LARM_ELBOW, LARM_WRIST_Y, "
    "LARM_WRIST_P, "
    "LARM_WRIST_R, WAIST_P, WAIST_R, CHEST";

struct Walked {
  double x = 0.0, lowest = 1e9;             // [m] of the base
  double lean = 0.0;                        // [rad] largest
  std::map<int, std::pair<int, int>> feet;  // by body: steps without force, steps with 0.9 of the weight
};

double calc_lean(const msg::Quaternion& q) {
  return 2.0 * std::atan2(std::hypot(q.x(), q.y()), std::hypot(q.w(), q.z()));
}

void take_forces(const msg::ContactForces& forces, double weight, Walked* walked) {
  std::map<int, double> carried;
  for (auto& foot : walked->feet) carried[foot.first] = 0.0;
  for (const auto& pair : forces.pairs()) carried[pair.body_a()] += pair.total().force().z();
  for (const auto& [body, force] : carried) {
    walked->feet[body].first += force == 0.0;
    walked->feet[body].second += force > 0.9 * weight;
  }
}

Walked read_walk(const std::string& log, double weight) {
  Walked walked;
  mcap::Reader reader(log);
  msg::RobotState state;
  msg::ContactForces forces;
  reader.read_messages(
      [&](const mcap::Message& message) {
        if (reader.channels().at(message.channel_id).topic == topics::kContactForces.name) {
          decode({message.data, message.size}, &forces);
          take_forces(forces, weight, &walked);
          return true;
        }
        decode({message.data, message.size}, &state);
        walked.x = state.X_WB().translation().x();
        walked.lowest = std::min(walked.lowest, state.X_WB().translation().z());
        walked.lean = std::max(walked.lean, calc_lean(state.X_WB().rotation()));
        return true;
      },
      {topics::kRobotState.name, topics::kContactForces.name});
  return walked;
}

TEST(Sr1, WalksItsPublishedPatternThroughSixProcesses) {
  const std::filesystem::path folder = std::filesystem::path(source_dir()) / "../shared/robots/sr1";
  if (!std::filesystem::exists(folder / "SR1.urdf")) GTEST_SKIP() << "NOT TESTED: ../shared/robots/sr1 is not there";
  const std::string scenario = get_test_folder() + "/sr1.yaml";
  std::ofstream(scenario) << "robot: " << (folder / "SR1.urdf").string() << "\nfeet: [LLEG_ANKLE_R, RLEG_ANKLE_R]\n"
                          << "ground: {friction: 1.0}\nservo: {default: {kp: 8000, kd: 100}}\n"
                          << "steps: {time_step: 0.001, control_period: 0.002, duration: 14.3}\n"
                          << "controller: {motion: " << (folder / "SR1WalkPattern1.seq").string() << ", joint_order: ["
                          << kOrder << "]}\n";
  ServerSet set("sr1", {scenario, "--no-plot"});
  ASSERT_EQ(set.wait(), 0) << set.output();
  const double weight = 130.8 * 9.81;  // [N]
  const Walked walked = read_walk(set.log(), weight);
  EXPECT_NEAR(walked.x, 0.46, 0.05) << "another engine, with this start: about 0.46 m";
  EXPECT_LT(walked.lean, 0.2) << "upright all the way";
  ASSERT_EQ(walked.feet.size(), 2u);
  for (const auto& [body, steps] : walked.feet) {
    EXPECT_GT(steps.first, 1000) << "foot forces alternate between zero ...";
    EXPECT_GT(steps.second, 1000) << "... and the whole weight";
  }
}

}  // namespace
}  // namespace hrp::test
