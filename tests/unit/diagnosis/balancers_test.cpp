// SPDX-License-Identifier: BSD-3-Clause
// A spring that carries the weight of an arm acts at its own joint, as a force that lifts a link would.
#include "diagnosis/evidence/balancers.h"

#include <gtest/gtest.h>

#include "tests/unit/diagnosis/torque_verdicts.h"

namespace hrp::diagnosis {
namespace {

GradedTerm make_force(const TorqueDesign& design, const Vector3d& force) {
  GradedTerm g;
  for (const Term& term : design.whole) {
    if (term.effect().id == EffectId::kExternalForce && term.place == kFore) g.term = term;
  }
  g.parameters = force;
  g.width = Eigen::VectorXd::Constant(3, 0.01);
  g.grade = Grade::kSupported;
  return g;
}

// An arm whose first joint turns about the vertical: a lift shows at the elbow alone.
Experiment make_upright(const std::string& name) {
  std::string upright = kArm;
  const std::string axis = "<axis xyz=\"0 1 0\"/>";
  upright.replace(upright.find(axis), axis.size(), "<axis xyz=\"0 0 1\"/>");
  return make_simulated_experiment(name, upright, kArmJoints, make_arm_drives());
}

TEST(Balancers, AForceAlongGravityThatOneJointAloneShowsMayBeASpringThere) {
  const Experiment e = make_upright("balancers_lift");
  const TorqueDesign design = make_torque_design(make_torque_data(e));
  std::vector<GradedTerm> graded{make_force(design, {0.0, 0.0, 9.0})};
  doubt_balancers(design, &graded);
  EXPECT_EQ(graded[0].grade, Grade::kAmbiguous);
  EXPECT_EQ(graded[0].balanced, kElbow);
}

// A force that lifts the forearm acts at the shoulder, too; one aside is no weight.
TEST(Balancers, AForceThatBothJointsShowOrThatPullsAsideIsNoBalancer) {
  const Experiment both = simulate_arm("balancers_both", make_arm_drives()), one = make_upright("balancers_aside");
  const TorqueDesign two_joints = make_torque_design(make_torque_data(both)),
                     one_joint = make_torque_design(make_torque_data(one));
  std::vector<GradedTerm> lifted{make_force(two_joints, {0.0, 0.0, 9.0})},
      aside{make_force(one_joint, {9.0, 0.0, 9.0})};
  doubt_balancers(two_joints, &lifted);
  doubt_balancers(one_joint, &aside);
  EXPECT_EQ(lifted[0].grade, Grade::kSupported);
  EXPECT_EQ(aside[0].grade, Grade::kSupported);
}

}  // namespace
}  // namespace hrp::diagnosis
