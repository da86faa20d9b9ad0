// SPDX-License-Identifier: BSD-3-Clause
// Worlds like reality: the generator's own laws and what its truth says of them.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "diagnosis/generator/dirt.h"
#include "diagnosis/generator/joint_reality.h"

namespace hrp::cases {
namespace {

TEST(DirtyCases, FrictionVariesOverPositionAndFadesWithTimeByItsShares) {
  JointReality joint;
  joint.coulomb = 2;
  joint.texture = 0.25;
  joint.texture_periods = 3;
  joint.fade_drop = 0.2;
  joint.fade_time = 5;
  const double crest = M_PI / 6;  // sin(3 q) = 1
  EXPECT_DOUBLE_EQ(calc_dry_friction(joint, crest, 1, 0, 0), 2.5);
  EXPECT_DOUBLE_EQ(calc_dry_friction(joint, -crest, 1, 0, 0), 1.5);
  EXPECT_NEAR(calc_dry_friction(joint, 0, 1, 0, 100), 1.6, 1e-8);  // exp(-20) of the drop is left
}

TEST(DirtyCases, EveryJointHasDryAndViscousFrictionAndARotor) {
  Prng random(4);
  const RobotPlan robot = make_arm(random);
  const Dirt dirt = draw_dirt(robot, {}, random);
  for (int j = 0; j < joint_count(robot); ++j) {
    std::set<std::string> effects;
    for (const Hidden& h : dirt.background) {
      if (h.where == joint(robot, j).name) effects.insert(h.effect);
    }
    EXPECT_TRUE(effects.count("viscous_friction") && effects.count("rotor_inertia")) << j;
    EXPECT_EQ(effects.count("coulomb_friction") + effects.count("stribeck_friction"), 1u) << j;
  }
}

TEST(DirtyCases, TheRotorBehindAHiddenTransmissionIsTheJointsOnly) {
  Prng random(4);
  const RobotPlan robot = make_arm(random);
  const std::string name = joint(robot, 0).name;
  std::vector<double> rotors;
  for (const Hidden& h :
       draw_dirt(robot, {{"joint_elasticity", "joint", name, {{"rotor_inertia", 0.25}}}}, random).background) {
    if (h.effect == "rotor_inertia" && h.where == name) rotors.push_back(h.get("inertia"));
  }
  EXPECT_EQ(rotors, std::vector<double>{0.25});
}

TEST(DirtyCases, EncodersResolveTwelveToSixteenBits) {
  Prng random(9);
  const RobotPlan robot = make_arm(random);
  for (int draw = 0; draw < 20; ++draw) {
    RecorderPlan plan;
    soil_recorder(robot, {}, &plan, random);
    const double bits = std::log2(2 * M_PI / plan.encoder_step);
    EXPECT_NEAR(bits, std::round(bits), 1e-9);
    EXPECT_TRUE(bits > 11.5 && bits < 16.5) << bits;
  }
}

}  // namespace
}  // namespace hrp::cases
