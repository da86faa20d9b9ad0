// SPDX-License-Identifier: BSD-3-Clause
// Other people's robots stand, and SR1 walks the two patterns published with it: loader, collision, motion and physics
// together, without a bus.
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/multibody/tree_mass.h"
#include "common/spatial/gravity.h"
#include "controller/motion/motion.h"
#include "servers/collision_checker/collision_world.h"
#include "servers/dynamics/simulator.h"
#include "servers/model_parser/robot_loader.h"
#include "tests/shared_files.h"

namespace hrp {
namespace {

// A robot, its world and the motion it plays.
class Rollout {
 public:
  explicit Rollout(const std::string& yaml)
      : robot_(load_robot(parse_scenario(yaml, "/test.yaml"))),
        scenario_(parse_scenario(robot_.scenario, "/test.yaml")),
        world_(robot_, scenario_),
        simulator_(robot_, scenario_) {
    command_.q = simulator_.state().q;
    if (scenario_.controller.motion.empty()) return;
    std::vector<std::string> joints;
    for (int i = 0; i < robot_.tree.num_joints(); ++i) joints.push_back(robot_.tree.joint(i).name);
    const std::string& path = scenario_.controller.motion;
    player_ =
        std::make_unique<MotionPlayer>(load_motion(path, scenario_.controller.joint_order), joints, command_.q, path);
  }
  // False when the simulator gives up.
  bool step() {
    if (player_ && simulator_.step_number() % scenario_.control_period == 0) {
      player_->sample(simulator_.time(), &command_.q, &command_.qd);
    }
    return simulator_.step(world_.calc_contacts(simulator_.state()), command_) == StepStatus::kOk;
  }
  const Simulator& simulator() const { return simulator_; }
  double weight() const { return calc_mass(robot_.tree) * kGravity; }

 private:
  RobotDescription robot_;
  Scenario scenario_;  // as the model parser gives it on
  CollisionWorld world_;
  Simulator simulator_;
  JointCommand command_;
  std::unique_ptr<MotionPlayer> player_;
};

// Angle between the base's z axis and the vertical [rad].
double calc_lean(const State& state) { return std::acos(std::min(1.0, (state.R_WB * Vector3d::UnitZ()).z())); }

struct Standing {
  const char* file;
  const char* feet;
  double kp, kd;  // [N m/rad], [N m s/rad]
};

class RealRobotStands : public ::testing::TestWithParam<Standing> {};

TEST_P(RealRobotStands, ForFiveSecondsOnItsOwnWeight) {
  const Standing& c = GetParam();
  const std::string path = find_shared(std::string("robots/") + c.file);
  if (path.empty()) GTEST_SKIP() << "NOT TESTED: ../shared/robots/" << c.file << " is not there";
  Rollout run("robot: " + path + "\nfeet: [" + c.feet + "]\nservo: {default: {kp: " + std::to_string(c.kp) +
              ", kd: " + std::to_string(c.kd) + "}}\n");
  const double start_height = run.simulator().state().p_WB.z();
  for (int k = 0; k < 5000; ++k) ASSERT_TRUE(run.step()) << run.simulator().fault_text();
  const State& state = run.simulator().state();
  EXPECT_LT(calc_lean(state), 0.1) << "soft servos give a little";
  EXPECT_NEAR(state.p_WB.z(), start_height, 0.02 * start_height);
  double carried = 0.0;
  for (const PairForce& pair : run.simulator().contact_forces()) carried += pair.total[5];
  EXPECT_NEAR(carried, run.weight(), 0.02 * run.weight()) << "still swaying slightly after five seconds";
}

INSTANTIATE_TEST_SUITE_P(
    Shared, RealRobotStands,
    ::testing::Values(Standing{"unitree_g1/g1_29dof_rev_1_0.urdf", "left_ankle_roll_link, right_ankle_roll_link", 500,
                               10},
                      Standing{"unitree_h1/h1.urdf", "left_ankle_link, right_ankle_link", 1500, 30},
                      Standing{"atlas/atlas_minimal_contact.urdf", "l_foot, r_foot", 8000, 80},
                      Standing{"jvrc1/jvrc1.urdf", "L_ANKLE_P_S, R_ANKLE_P_S", 5000, 30},
                      Standing{"ergocub/ergoCubGazeboV1_3_minContacts.urdf",
                               "l_foot_front, l_foot_rear, r_foot_front, r_foot_rear", 2000, 20},
                      Standing{"robotis_op3/robotis_op3.urdf", "l_ank_roll_link, r_ank_roll_link", 100, 1}));

// Joints by Choreonoid's joint id.
const char kSr1Order[] =
    "RLEG_HIP_R, RLEG_HIP_P, RLEG_HIP_Y, RLEG_KNEE, RLEG_ANKLE_P, RLEG_ANKLE_R, RARM_SHOULDER_P, RARM_SHOULDER_R, "
    "RARM_SHOULDER_Y, RARM_ELBOW, RARM_WRIST_Y, RARM_WRIST_P, RARM_WRIST_R, LLEG_HIP_R, LLEG_HIP_P, LLEG_HIP_Y, "
    "LLEG_KNEE, "
    "LLEG_ANKLE_P, LLEG_ANKLE_R, LARM_SHOULDER_P, LARM_SHOULDER_R, LARM_SHOULDER_Y, LARM_ELBOW, LARM_WRIST_Y, "
    "LARM_WRIST_P, "
    "LARM_WRIST_R, WAIST_P, WAIST_R, CHEST";

class Sr1Walks : public ::testing::TestWithParam<const char*> {};

// On one foot the contact must be stiffer in roll than m g h, about 1 kN m/rad for 130.8 kg: 2e5 N/m gives this sole
// 2e5 x (0.07 m)^2 = 0.98 kN m/rad, and the robot falls (so it does with 5e5). Contact and start pose are the defaults.
TEST_P(Sr1Walks, ItsPublishedPatternToTheEndUprightAndForward) {
  const std::string urdf = find_shared("robots/sr1/SR1.urdf"),
                    motion = find_shared(std::string("robots/sr1/") + GetParam());
  if (urdf.empty() || motion.empty()) GTEST_SKIP() << "NOT TESTED: ../shared/robots/sr1 is not there";
  Rollout run("robot: " + urdf +
              "\nfeet: [LLEG_ANKLE_R, RLEG_ANKLE_R]\nground: {friction: 1.0}\n"
              "servo: {default: {kp: 8000, kd: 100}}\nsteps: {time_step: 0.001, control_period: 0.002}\n"
              "controller: {motion: " +
              motion + ", joint_order: [" + kSr1Order + "]}\n");
  std::vector<double> swung = {0.0, 0.0}, carried = {0.0, 0.0};  // [s] each foot in the air, and alone under the weight
  double lean = 0.0;
  for (int k = 0; k < 14300; ++k) {
    ASSERT_TRUE(run.step()) << run.simulator().fault_text();
    lean = std::max(lean, calc_lean(run.simulator().state()));
    for (size_t foot = 0; foot < 2; ++foot) {
      const double force = run.simulator().foot_forces()[foot];
      swung[foot] += force == 0.0 ? 0.001 : 0.0;
      carried[foot] += force > 0.9 * run.weight() && run.simulator().foot_forces()[1 - foot] == 0.0 ? 0.001 : 0.0;
    }
  }
  EXPECT_LT(lean, 0.2) << "upright all the way";
  EXPECT_NEAR(run.simulator().state().p_WB.x(), 0.46, 0.05) << "another engine: about 0.46 m";
  for (size_t foot = 0; foot < 2; ++foot) {
    EXPECT_GT(swung[foot], 1.0) << "foot forces alternate between zero ...";
    EXPECT_GT(carried[foot], 1.0) << "... and the whole weight";
  }
}

INSTANTIATE_TEST_SUITE_P(Shared, Sr1Walks, ::testing::Values("SR1WalkPattern1.seq", "SR1WalkPattern2.seq"));

}  // namespace
}  // namespace hrp
