// SPDX-License-Identifier: BSD-3-Clause
// The rollout and the fit on a pendulum made here: what was put in comes out.
#include <gtest/gtest.h>

#include "diagnosis/report/report.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

constexpr const char* kUrdf = R"(<robot name="arm"><link name="base"/><link name="l1"><inertial><origin xyz="0 0 -0.2"/>
<mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial></link>
<joint name="j1" type="revolute"><parent link="base"/><child link="l1"/><origin xyz="0 0 0"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="50" velocity="10"/></joint></robot>)";

Experiment make_experiment(const std::string& name, const Hypothesis& hidden) {
  return make_simulated_experiment(name, kUrdf, {"j1"}, hidden);
}

TEST(Diagnosis, FindsNothingWhereNothingIsHidden) {
  const Experiment e = make_experiment("none", {});
  const Problem problem = make_problem(e, 1);
  const Outcome outcome = search(problem, [](const std::string&) {});
  EXPECT_FALSE(outcome.mismatch);
  EXPECT_NEAR(outcome.nominal.rms, 1.0, 0.05);   // 3600 readings: 1.2 % of chance, start of the rollout
}

TEST(Diagnosis, RecoversViscousFriction) {
  const Experiment e = make_experiment("viscous", {{EffectId::kViscous, 0, {0.7}}});
  const Problem problem = make_problem(e, 1);
  const Outcome outcome = search(problem, [](const std::string&) {});
  ASSERT_TRUE(outcome.explained);
  ASSERT_EQ(outcome.chosen.hypothesis.size(), 1u);
  EXPECT_EQ(outcome.chosen.hypothesis[0].id, EffectId::kViscous);
  EXPECT_NEAR(outcome.chosen.hypothesis[0].p[0], 0.7, 0.01);
  EXPECT_LT(outcome.chosen.rms, 1.2);
}

TEST(Diagnosis, DoesNotDependOnTheNumberOfThreads) {
  const Experiment e = make_experiment("threads", {{EffectId::kRotorInertia, 0, {0.05}}});
  Reports reports[2];
  for (int jobs = 1; jobs <= 2; ++jobs) {
    const Problem problem = make_problem(e, jobs);
    reports[jobs - 1] = diagnose(problem, [](const std::string&) {});
  }
  EXPECT_EQ(reports[0].report.dump(), reports[1].report.dump());
  EXPECT_EQ(reports[0].report["findings"][0]["effect"], "rotor_inertia");
}

}  // namespace
}  // namespace hrp::diagnosis
