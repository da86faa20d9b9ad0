// SPDX-License-Identifier: BSD-3-Clause
// Friction that a URDF states: what the recordings refute is taken out and said, what is there stays.
#include <gtest/gtest.h>

#include "diagnosis/conventions/stated_friction.h"
#include "diagnosis/data/urdf_text.h"
#include "diagnosis/diagnose_recordings.h"
#include "tests/shared_files.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

void state_friction(double viscous, double dry, Experiment* e) {
  for (int j = 0; j < e->num_joints(); ++j) {
    e->robot.tree.joint(j).viscous_friction = viscous;
    e->robot.tree.joint(j).coulomb_friction = dry;
  }
}

Hypothesis make_friction(double viscous, double dry) {
  Hypothesis out;
  for (int j : {kShoulder, kElbow}) {
    out.push_back({EffectId::kViscous, j, {viscous}});
    out.push_back({EffectId::kCoulomb, j, {dry, 0.0, 5e-4}});
  }
  return out;
}

TEST(StatedFriction, OfAPlaceholderIsRefutedWithWhatIsThere) {
  Experiment e = simulate_arm("placeholder", make_friction(0.2, 0.3));
  state_friction(1.0, 0.0, &e);
  const std::vector<RefutedFriction> refuted = find_refuted_friction(e);
  ASSERT_EQ(refuted.size(), 2u);
  for (const RefutedFriction& r : refuted) {
    EXPECT_FALSE(r.effect->dry);
    EXPECT_NEAR(r.found, 0.2, 0.05) << "4 standard deviations of 0.012";
    EXPECT_EQ(r.stated, 1.0);
  }
  EXPECT_EQ(drop_friction(e, refuted).robot.tree.joint(0).viscous_friction, 0.0);
}

TEST(StatedFriction, ThatIsThereStaysAndADriveThatGivesMoreDoesNotRefuteIt) {
  Hypothesis reality = make_friction(0.5, 0.6);
  Experiment same = simulate_arm("stated_right", reality);
  state_friction(0.5, 0.6, &same);
  EXPECT_TRUE(find_refuted_friction(same).empty());
  reality.push_back({EffectId::kTorqueConstant, kShoulder, {1.4}});
  Experiment strong = simulate_arm("stated_gain", reality);
  state_friction(0.5, 0.6, &strong);
  EXPECT_TRUE(find_refuted_friction(strong).empty());
}

TEST(StatedFriction, ThatIsThereStaysBesideAPlaceholderOfTheOtherKind) {
  Experiment e = simulate_arm("one_right", make_friction(0.2, 0.3));
  state_friction(1.0, 0.3, &e);
  for (const RefutedFriction& r : find_refuted_friction(e))
    EXPECT_FALSE(r.effect->dry) << r.found << " of " << r.stated << " +- " << r.std;
}

TEST(StatedFriction, ThatIsNotThereIsAFindingAndNoOtherEffectIsNamedForIt) {
  Experiment e = simulate_arm("nothing_there", {});
  state_friction(0.5, 0.0, &e);
  const Reports reports = diagnose_recordings(
      e, {1, 1.0}, [](const std::string&) {}, [](const Reports&) {});
  ASSERT_EQ(reports.report["findings"].size(), 2u) << reports.report["findings"].dump(1);
  EXPECT_EQ(reports.report["verdict"], "explained") << "without it, noise is left";
  for (const Json& f : reports.report["findings"]) {
    EXPECT_EQ(f["effect"], "viscous_friction");
    EXPECT_EQ(f["replaces"], 0.5);
    const double std = f["parameters"]["coefficient"]["std"];
    EXPECT_LT(std, 0.04 * 0.5);  // a small part of what is stated
    EXPECT_NEAR(f["parameters"]["coefficient"]["value"].get<double>(), 0.0, 4.0 * std);
  }
}

TEST(UrdfText, AnAttributeChangesInTheJointThatIsNamedAlone) {
  const std::string urdf =
      "<robot><transmission><joint name='a'/></transmission><joint name='z' type='revolute'><parent link='w'/>"
      "<dynamics friction='0.8' damping='0.8'/></joint><!-- <joint name='a' type='revolute'><parent link='x'/>"
      "<dynamics friction='0.9' damping='0.9'/></joint> --><joint name='a' type='revolute'><parent link='x'/>"
      "<dynamics friction = \"0.4\" damping='0.3'/></joint><joint name='ab' type='revolute'><parent "
      "link='y'/><dynamics damping='0.7'/></joint></robot>";
  const std::string cleared =
      set_joint_attribute(set_joint_attribute(urdf, "a", "dynamics", "damping", "0"), "a", "dynamics", "friction", "0");
  EXPECT_NE(cleared.find("<dynamics friction = \"0\" damping='0'/>"), std::string::npos) << cleared;
  EXPECT_NE(cleared.find("damping='0.7'"), std::string::npos);
  EXPECT_NE(cleared.find("friction='0.8' damping='0.8'"), std::string::npos)
      << "behind the transmission of another one";
  EXPECT_NE(cleared.find("friction='0.9' damping='0.9'"), std::string::npos) << "a comment";
  EXPECT_NE(set_joint_attribute(urdf, "ab", "", "type", "fixed").find("name='ab' type='fixed'"), std::string::npos);
  EXPECT_EQ(set_joint_attribute(urdf, "b", "dynamics", "damping", "0"), urdf);
  EXPECT_EQ(set_joint_attribute(urdf, "a", "limit", "effort", "0"), urdf);
}

// Friction of a real pendulum with placeholders in its model is that without them.
TEST(StatedFriction, OfARealPendulumWithPlaceholdersIsWhatItIsWithoutThem) {
  const std::string path = find_shared("recordings/dfki_double_pendulum/experiment.yaml");
  if (path.empty()) GTEST_SKIP() << "the recordings are not there, NOTHING was checked";
  Experiment e = load_experiment(path);
  state_friction(0.3, 0.4, &e);
  const std::vector<RefutedFriction> refuted = find_refuted_friction(e);
  EXPECT_EQ(refuted.size(), 4u);
  e = drop_friction(e, refuted);
  EXPECT_EQ(e.robot.tree.joint(0).viscous_friction + e.robot.tree.joint(1).coulomb_friction, 0.0);
}

}  // namespace
}  // namespace hrp::diagnosis
