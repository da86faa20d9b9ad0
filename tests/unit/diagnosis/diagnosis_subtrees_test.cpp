// SPDX-License-Identifier: BSD-3-Clause
// A robot whose base stands still, subtree by subtree.
#include <gtest/gtest.h>

#include "diagnosis/report/report.h"
#include "diagnosis/search/subtrees.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

std::string make_link(const std::string& name, double length, double mass) {
  return "<link name=\"" + name + "\"><inertial><origin xyz=\"0 0 " + std::to_string(-0.5 * length) +
         "\"/><mass value=\"" + std::to_string(mass) +
         "\"/><inertia ixx=\"0.02\" ixy=\"0\" ixz=\"0\" iyy=\"0.02\" iyz=\"0\" izz=\"0.01\"/></inertial></link>";
}

std::string make_joint(const std::string& name, const std::string& parent, const std::string& child, double y,
                       double z) {
  return "<joint name=\"" + name + "\" type=\"revolute\"><parent link=\"" + parent + "\"/><child link=\"" + child +
         "\"/><origin xyz=\"0 " + std::to_string(y) + " " + std::to_string(z) +
         "\"/><axis xyz=\"0 1 0\"/><limit lower=\"-3\" upper=\"3\" effort=\"50\" velocity=\"10\"/></joint>";
}

// A trunk that is held, a leg of two joints and one of one joint.
std::string make_urdf() {
  return "<robot name=\"hung\"><link name=\"trunk\"/>" + make_link("thigh_l", 0.3, 2.0) + make_link("leg_r", 0.4, 2.5) +
         make_link("shank_l", 0.3, 1.0) + make_joint("hip_l", "trunk", "thigh_l", 0.1, 0.0) +
         make_joint("hip_r", "trunk", "leg_r", -0.1, 0.0) + make_joint("knee_l", "thigh_l", "shank_l", 0.0, -0.3) +
         "</robot>";
}

Experiment make_experiment(const std::string& name, const Hypothesis& hidden) {
  return make_simulated_experiment(name, make_urdf(), {"hip_l", "hip_r", "knee_l"}, hidden);
}

int find_joint(const Experiment& e, const char* name) { return e.robot.tree.find_joint(name); }

TEST(DiagnosisLimbs, AreJointsThatShareAMovingLink) {
  const Experiment e = make_experiment("limbs_list", {});
  const std::vector<std::vector<int>> subtrees = list_subtrees(e.robot.tree);
  ASSERT_EQ(subtrees.size(), 2u);
  const std::vector<int> left{find_joint(e, "hip_l"), find_joint(e, "knee_l")}, right{find_joint(e, "hip_r")};
  EXPECT_TRUE((subtrees[0] == left && subtrees[1] == right) || (subtrees[0] == right && subtrees[1] == left));
}

TEST(DiagnosisLimbs, OnABaseThatStandsStillDoNotFeelEachOther) {
  const Experiment e = make_experiment("limbs_free", {});
  Problem whole = make_problem(e, 1), split = whole;
  split_subtrees(&split);
  ASSERT_EQ(split.subtrees.size(), 2u);
  const Hypothesis hypothesis{{EffectId::kRotorInertia, find_joint(e, "knee_l"), {0.05}},
                              {EffectId::kMassError, find_joint(e, "hip_r") + 1, {1.2}},
                              {EffectId::kSensorBias, at_sensor(find_joint(e, "hip_r"), Reading::kPosition), {0.01}}};
  std::vector<double> together, apart;
  ASSERT_TRUE(calc_residuals(whole, hypothesis, 0, &together));
  ASSERT_TRUE(calc_residuals(split, hypothesis, 0, &apart));
  ASSERT_EQ(together.size(), apart.size());
  double largest = 0.0;
  for (size_t i = 0; i < together.size(); ++i) largest = std::max(largest, std::abs(together[i] - apart[i]));
  EXPECT_LT(largest, 1e-5);  // noise deviations: rounding, summed up over 12000 steps
}

TEST(DiagnosisLimbs, TwoCausesInTwoLimbsAreOneExplanationOfTheRobot) {
  const Experiment bare = make_experiment("limbs_names", {});
  const int knee = find_joint(bare, "knee_l"), hip = find_joint(bare, "hip_r");
  const Experiment e =
      make_experiment("limbs_both", {{EffectId::kViscous, knee, {0.7}}, {EffectId::kRotorInertia, hip, {0.05}}});
  const auto report = diagnose(make_problem(e, 1), [](const std::string&) {}).report;
  EXPECT_EQ(report["verdict"], "explained");
  ASSERT_EQ(report["findings"].size(), 2u) << report["findings"].dump(1);
  for (const auto& finding : report["findings"]) {
    const bool friction = finding["effect"] == "viscous_friction";
    EXPECT_EQ(finding["where"]["joint"], friction ? "knee_l" : "hip_r");
    const auto& value = finding["parameters"][friction ? "coefficient" : "inertia"];
    EXPECT_NEAR(value["value"].get<double>(), friction ? 0.7 : 0.05,
                friction ? 0.007 : 0.0005);  // 1 %: the noise's share
  }
  for (const char* part : {"train", "validate"}) {
    // The noise, to 5 %; without the findings far above it.
    EXPECT_NEAR(report["fit"][part]["after"].get<double>(), 1.0, 0.05);
    EXPECT_GT(report["fit"][part]["before"].get<double>(), 1.5);
  }
  EXPECT_EQ(report["fit"]["over"], "noise");
}

}  // namespace
}  // namespace hrp::diagnosis
