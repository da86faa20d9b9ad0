// SPDX-License-Identifier: BSD-3-Clause
// The robots of models/ are what their README files say.
#include <algorithm>

#include <gtest/gtest.h>

#include "common/multibody/kinematics.h"
#include "common/robot/sole.h"
#include "servers/model_parser/robot_loader.h"
#include "tests/test_places.h"

namespace hrp {
namespace {

struct OwnRobot {
  Scenario scenario;
  RobotDescription robot;
};

OwnRobot load_own(const std::string& scenario) {
  OwnRobot own;
  own.scenario = load_scenario(source_dir() + "/models/scenarios/" + scenario);
  own.robot = load_robot(own.scenario);
  return own;
}

// The pose of the fact sheet's figures: legs as in the scenario, arms hanging straight down.
OwnRobot hang_arms(OwnRobot own) {
  for (auto it = own.scenario.initial_joints.begin(); it != own.scenario.initial_joints.end();) {
    const bool arm = it->first.find("SHOULDER") != std::string::npos || it->first.find("ELBOW") != std::string::npos;
    it = arm ? own.scenario.initial_joints.erase(it) : std::next(it);
  }
  return own;
}

// Centre of mass above the ground and total mass, in the start pose of the scenario.
void calc_mass_and_height(const OwnRobot& own, double* mass, Vector3d* p_WCcm) {
  const Model model(own.robot.tree);
  Data data(model);
  update_kinematics(model, make_start_state(own.robot, own.scenario), &data);
  *mass = 0.0;
  p_WCcm->setZero();
  for (size_t i = 0; i < own.robot.tree.links.size(); ++i) {
    const LinkInertia& inertia = own.robot.tree.links[i].inertia;
    *mass += inertia.mass;
    *p_WCcm += inertia.mass * (get_pose(data, static_cast<int>(i)) * inertia.p_LLcm_L);
  }
  *p_WCcm /= *mass;
}

// Highest point of the collision shapes (boxes) above the ground with all joints straight.
double calc_straight_height(OwnRobot own) {
  own.scenario.initial_joints.clear();
  const Model model(own.robot.tree);
  Data data(model);
  update_kinematics(model, make_start_state(own.robot, own.scenario), &data);
  double top = 0.0;
  for (const CollisionShape& shape : own.robot.shapes) {
    const Transform X_WG = get_pose(data, shape.link) * shape.X_LG;
    top = std::max(top, X_WG.p.z() + 0.5 * shape.size.dot(X_WG.R.row(2).transpose().cwiseAbs()));
  }
  return top;
}

TEST(OwnModels, Hrp2pLikeHasThePublishedMassHeightAndHalfSittingPose) {
  const OwnRobot own = hang_arms(load_own("squat.yaml"));
  double mass = 0.0;
  Vector3d p_WCcm;
  calc_mass_and_height(own, &mass, &p_WCcm);
  EXPECT_NEAR(mass, 58.0, 1e-9);
  EXPECT_EQ(own.robot.tree.num_joints(), 30);
  EXPECT_NEAR(p_WCcm.z(), 0.812, 5e-4) << "fact: 0.812 m, to the millimetre";
  EXPECT_NEAR(make_start_state(own.robot, own.scenario).p_WB.z(), 0.6487, 5e-5) << "published waist height";
  EXPECT_NEAR(calc_straight_height(own), 1.540, 1e-3);
}

TEST(OwnModels, Hrp1sLikeHasThePublishedMassAndHeight) {
  const OwnRobot own = hang_arms(load_own("hrp1s_stand.yaml"));
  double mass = 0.0;
  Vector3d p_WCcm;
  calc_mass_and_height(own, &mass, &p_WCcm);
  EXPECT_NEAR(mass, 120.0, 1e-9);
  EXPECT_EQ(own.robot.tree.num_joints(), 30);
  EXPECT_NEAR(p_WCcm.z(), 0.863, 1e-3) << "the fact sheet rounds the knee angle to 38 degrees: half a degree is 1 mm";
  EXPECT_NEAR(calc_straight_height(own), 1.600, 1e-3);
}

TEST(OwnModels, CentresOfMassStandAboveTheSoles) {
  for (const char* name : {"squat.yaml", "hrp1s_stand.yaml"}) {
    const OwnRobot own = load_own(name);
    double mass = 0.0;
    Vector3d p_WCcm;
    calc_mass_and_height(own, &mass, &p_WCcm);
    const Model model(own.robot.tree);
    Data data(model);
    update_kinematics(model, make_start_state(own.robot, own.scenario), &data);
    double front = -1.0, rear = 1.0;
    for (const Sole& sole : make_soles(own.robot)) {
      for (const SolePoint& point : sole.points) {
        const double x = (get_pose(data, sole.link) * point.p_LQ).x();
        front = std::max(front, x);
        rear = std::min(rear, x);
      }
    }
    EXPECT_GT(p_WCcm.x(), rear + 0.05) << name << ": 5 cm of margin";
    EXPECT_LT(p_WCcm.x(), front - 0.05) << name;
    EXPECT_NEAR(p_WCcm.y(), 0.0, 1e-6) << name;
  }
}

TEST(OwnModels, EveryJointHasARotorInertia) {
  for (const char* name : {"squat.yaml", "hrp1s_stand.yaml"}) {
    const TreeSpec tree = load_own(name).robot.tree;
    for (int i = 0; i < tree.num_joints(); ++i) EXPECT_GT(tree.joint(i).rotor_inertia, 0.0) << tree.joint(i).name;
  }
}

}  // namespace
}  // namespace hrp
