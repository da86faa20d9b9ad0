// SPDX-License-Identifier: BSD-3-Clause
// What a fitted hypothesis leaves, and which second cause it asks for.
#include <gtest/gtest.h>

#include "diagnosis/report/report.h"
#include "diagnosis/search/additions.h"
#include "diagnosis/search/start_state.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

const Effect kLoad{EffectId::kPayload, kFore, {0.8, 0.25, 0.0, 0.05, 0.0}};

std::vector<Addition> rank_beside_load(const std::string& name, const Hypothesis& hidden, Score* left) {
  const Experiment e = simulate_arm(name, hidden);
  Problem problem = make_problem(e, 1);
  std::vector<int> all(e.recordings.size());
  for (size_t r = 0; r < all.size(); ++r) all[r] = static_cast<int>(r);
  problem.starts = estimate_starts(problem, {kLoad}, all);
  const FitResult fitted = fit(problem, {kLoad}, problem.train, {});
  *left = fitted.train;
  return rank_additions(problem, fitted.hypothesis);
}

TEST(DiagnosisAdditions, ATorqueConstantBelowALoadIsAskedForFirst) {
  Score left;
  const auto ranked = rank_beside_load("additions_scale", {kLoad, {EffectId::kTorqueConstant, kElbow, {1.04}}}, &left);
  ASSERT_FALSE(ranked.empty());
  EXPECT_EQ(ranked[0].start.id, EffectId::kTorqueConstant);
  EXPECT_EQ(ranked[0].start.place, at_joint(kElbow));
  EXPECT_NEAR(ranked[0].start.p[0], 1.04, 0.01);  // a linear start, not a fit: a quarter of the error
  EXPECT_GT(ranked[0].gain, 0.5 * (left.chi2 - left.count));
}

TEST(DiagnosisAdditions, NoiseAsksForNothing) {
  Score left;
  const auto ranked = rank_beside_load("additions_noise", {kLoad}, &left);
  // Some 70 effects are looked at; the largest of so many chi^2 of up to four degrees is about 20, held-out ones and
  // correlated residuals allowed for below 60.
  EXPECT_LT(ranked.empty() ? 0.0 : ranked[0].gain, 60.0);
  EXPECT_NEAR(left.rms(), 1.0, 0.05);
}

TEST(DiagnosisAdditions, ALoadBesideAShiftedEffortReadingIsFoundWithItsPlace) {
  const Place reading = at_sensor(kShoulder, Reading::kEffort);
  const Experiment e = simulate_arm("additions_bias", {kLoad, {EffectId::kSensorBias, reading, {3.0}}});
  const auto report = diagnose(make_problem(e, 1), [](const std::string&) {}).report;
  EXPECT_EQ(report["verdict"], "explained");
  ASSERT_EQ(report["findings"].size(), 2u) << report["findings"].dump(1);
  for (const auto& finding : report["findings"]) {
    const bool load = finding["effect"] == "payload";
    EXPECT_EQ(finding["where"][load ? "link" : "sensor"], load ? "fore" : "/joint_states/shoulder/effort");
    const auto& value = finding["parameters"][load ? "mass" : "value"];
    EXPECT_NEAR(value["value"].get<double>(), load ? 0.8 : 3.0, load ? 0.008 : 0.03);  // 1 %: the noise's share
  }
}

}  // namespace
}  // namespace hrp::diagnosis
