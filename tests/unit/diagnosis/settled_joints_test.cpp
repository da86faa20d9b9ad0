// SPDX-License-Identifier: BSD-3-Clause
// Of two causes one may stay unknown. What is known of the other joint is told.
#include "diagnosis/evidence/settled_joints.h"

#include "tests/unit/diagnosis/torque_verdicts.h"

namespace hrp::diagnosis {
namespace {

// Held-out squares over the noise of the shoulder and of the elbow, by position.
Score make_score(double shoulder, double elbow) {
  Score score;
  score.signal_chi2.assign(2 * kQuantities, 0.0);
  score.signal_count.assign(2 * kQuantities, 100.0);
  score.signal_chi2[kShoulder * kQuantities] = shoulder;
  score.signal_chi2[kElbow * kQuantities] = elbow;
  return score;
}

Outcome make_outcome(double elbow_left) {
  Outcome outcome;
  outcome.mismatch = true;
  outcome.nominal.validate = make_score(2e4, 2e6);
  Trial friction;
  friction.hypothesis = {{EffectId::kCoulomb, kElbow, {0.4, 0.0, 5e-4}}};
  friction.std = {{0.001, 0.0, 0.0}};
  friction.refined = true;
  friction.validate = make_score(2e4, elbow_left);
  outcome.rivals = {friction};
  return outcome;
}

Finding make_found(const std::string& joint, Grade grade) {
  Finding f;
  f.effect = "coulomb_friction";
  f.where = {{"joint", joint}};
  f.grade = grade;
  return f;
}

TEST(SettledJoints, AreNamedWhereAnotherJointStaysUnexplained) {
  const Experiment e = simulate_arm("settled", make_arm_drives());
  const Problem problem = make_problem(e, 1);
  const auto name = [&](double left, const Finding& found) {
    return name_settled_joints(problem, make_outcome(left), {found});
  };
  const auto named =
      name(5e3, make_found("elbow", Grade::kSupported));  // 0.25 % of the squares: the other joint's error
  ASSERT_TRUE(named.has_value());
  EXPECT_TRUE(named->partly);
  EXPECT_FALSE(named->explained);
  ASSERT_EQ(named->chosen.hypothesis.size(), 1u);
  EXPECT_EQ(named->chosen.hypothesis[0].id, EffectId::kCoulomb);
  EXPECT_FALSE(name(1e5, make_found("elbow", Grade::kSupported))) << "5 % are left: another law of friction";
  EXPECT_FALSE(name(5e3, make_found("elbow", Grade::kAmbiguous))) << "the missing torque is not sure";
  EXPECT_FALSE(name(5e3, make_found("shoulder", Grade::kSupported))) << "the missing torque names it elsewhere";
}

}  // namespace
}  // namespace hrp::diagnosis
