// SPDX-License-Identifier: BSD-3-Clause
// An effect that is one row of the table and that no other code mentions: it is simulated, found, and named.
#include "common/effects/effect_info.h"
#include "diagnosis/report/report.h"
#include "simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

// The search does not find this limit yet (docs/effects.md). It must say where something is missing, and name nothing else.
TEST(VelocityLimit, IsPlacedAndNotTakenForAnotherEffect) {
  const EffectInfo* row = find_effect("velocity_limit");
  ASSERT_NE(row, nullptr);
  const Experiment e = make_simulated_experiment("velocity_limit", kArm, {"shoulder", "elbow"},
                                                 {{row->id, kElbow, {3.0, 3.5}}});
  const auto report = diagnose(make_problem(e, 1), [](const std::string&) {}).report;
  for (const auto& finding : report["findings"]) EXPECT_EQ(finding["effect"], "velocity_limit") << finding.dump(1);
  ASSERT_FALSE(report["mismatch"].empty());
  EXPECT_EQ(report["mismatch"][0]["signal"], "/joint_states/elbow/position");
}

}  // namespace
}  // namespace hrp::diagnosis
