// SPDX-License-Identifier: BSD-3-Clause
// An effect that is one row of the table and that no other code mentions: it is simulated, found, and named.
#include "common/effects/effect_info.h"
#include "diagnosis/report/report.h"
#include "simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

TEST(VelocityLimit, IsFoundWhereItIsWithItsStallTorqueAndItsSpeed) {
  const EffectInfo* row = find_effect("velocity_limit");
  ASSERT_NE(row, nullptr);
  const Experiment e = simulate_arm("velocity_limit", {{row->id, kElbow, {2.2, 4.0}}});
  const auto report = diagnose(make_problem(e, 1), [](const std::string&) {}).report;
  ASSERT_EQ(report["findings"].size(), 1u) << report.dump(1);
  const auto& finding = report["findings"][0];
  EXPECT_EQ(finding["effect"], "velocity_limit");
  EXPECT_EQ(finding["where"]["joint"], "elbow");
  // The bar of every parameter: 5 %.
  EXPECT_NEAR(finding["parameters"]["stall_torque"]["value"].get<double>(), 2.2, 0.11);
  EXPECT_NEAR(finding["parameters"]["max_speed"]["value"].get<double>(), 4.0, 0.2);
}

TEST(DeadZone, IsFoundWhereItIsWithItsWidth) {
  const EffectInfo* row = find_effect("dead_zone");
  ASSERT_NE(row, nullptr);
  const Experiment e = simulate_arm("dead_zone", {{row->id, kElbow, {0.6}}});
  const auto report = diagnose(make_problem(e, 1), [](const std::string&) {}).report;
  ASSERT_EQ(report["findings"].size(), 1u) << report.dump(1);
  const auto& finding = report["findings"][0];
  EXPECT_EQ(finding["effect"], "dead_zone");
  EXPECT_EQ(finding["where"]["joint"], "elbow");
  EXPECT_NEAR(finding["parameters"]["width"]["value"].get<double>(), 0.6, 0.03);
}

}  // namespace
}  // namespace hrp::diagnosis
