// SPDX-License-Identifier: BSD-3-Clause
// A law has one size in every regime that tells it.
#include "diagnosis/floating/fit/regimes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/unit/diagnosis/legged/biped.h"
#include "tests/unit/diagnosis/legged/rows.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr auto kPhase = RegimeKind::kPhase, kCalm = RegimeKind::kCalm, kRough = RegimeKind::kRough;

TEST(LeggedRegimes, WhatIsThereInOnePhaseOnlyIsNoLaw) {
  EXPECT_TRUE(is_steady({{kPhase, "phase 1", 1.2, 0.05}, {kPhase, "phase 2", 0.8, 0.05}}));
  EXPECT_FALSE(is_steady({{kPhase, "phase 1", 1.2, 0.05}, {kPhase, "phase 2", 0.1, 0.05}}));
  EXPECT_TRUE(is_steady({{kPhase, "phase 1", 1.0, 0.05}, {kPhase, "phase 2", 0.1, 0.4}}));  // phase 2 tells nothing
}

TEST(LeggedRegimes, NoLawChangesItsSignFromPhaseToPhase) {
  EXPECT_FALSE(is_steady({{kPhase, "phase 1", 1.2, 0.1}, {kPhase, "phase 2", -0.5, 0.45}}));  // 3.3 deviations from 1
  EXPECT_TRUE(is_steady({{kPhase, "phase 1", 1.2, 0.1}, {kPhase, "phase 2", -0.5, 0.55}}));   // by chance
}

Regime make_phase(double size, double std) { return {kPhase, "phase", size, std}; }

// A sensor's scale that the stance on one foot tells as half of what the stance on both tells is known no better than
// that.
TEST(LeggedRegimes, PhasesThatDisagreeMakeAValueUncertain) {
  EXPECT_DOUBLE_EQ(find_phase_spread({make_phase(0.5, 0.1), make_phase(1.1, 0.05), {kCalm, "calm", 0.3, 0.01}}), 0.5);
  EXPECT_EQ(find_phase_spread({make_phase(0.8, 0.1), make_phase(1.1, 0.05)}), 0.0);  // two deviations: chance
  EXPECT_EQ(find_phase_spread({make_phase(0.1, 0.25)}), 0.0);                        // it tells nothing
}

// Rigid feet that roll over an edge turn under a moment, too, but not while they are pressed in the middle.
TEST(LeggedRegimes, ASoleGivesWhereItIsPressedInTheMiddle) {
  EXPECT_TRUE(
      is_steady({{kPhase, "phase 1", 0.7, 0.05}, {RegimeKind::kMiddle, "pressed in the middle", 0.9, 0.05, 0.8}}));
  EXPECT_FALSE(
      is_steady({{kPhase, "phase 1", 0.7, 0.05}, {RegimeKind::kMiddle, "pressed in the middle", 0.7, 0.05, 0.8}}));
}

// A foot that bears 0 to 500 N; its sensor reads 6 % too much, or 30 N. One column tries a scale, one a zero.
bool is_fault_steady(bool is_scale, bool of_scale) {
  const ColumnLayout layout(make_legged_log(make_biped({}), Half::kEven));
  const int scale = layout.sensor(0, kForceScaleColumn), zero = layout.sensor(0, kForceBiasColumn + 2);
  std::mt19937 random(19);
  std::normal_distribution<double> normal;
  RowHalves rows(layout.count(), 600, {{kWeight, {scale, zero}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const double bears = 250 + 250 * std::sin(0.05 * i);
    rows.add_cell(i, get_mixed_roughness(i), [&](RowTable* half, double) {
      half->begin_row(0, (is_scale ? 0.06 * bears : 30) + normal(random), 500);
      half->add(0, scale, bears);
      half->add(0, zero, 1);
    });
  }
  LeggedFitter fitter(rows.merge(), layout.count());
  Candidate fault =
      make_candidate(of_scale ? EffectId::kSensorScale : EffectId::kSensorBias, "", {{{of_scale ? scale : zero, 1.0}}});
  fault.place = 0;
  fault.where = {{"sensor", "/wrench/l/force"}};
  fitter.update_weights(fitter.fit({fault}));
  return is_steady(list_regimes(fitter, fitter.fit({fault}), 0, layout));
}

TEST(LeggedRegimes, AZeroOfAForceThatGrowsWithWhatTheFootBearsIsNone) {
  EXPECT_FALSE(is_fault_steady(true, false));
  EXPECT_TRUE(is_fault_steady(true, true));
  EXPECT_TRUE(is_fault_steady(false, false));
}

TEST(LeggedRegimes, CalmAndRoughRowsThatDisagreeAreTwoCauses) {
  EXPECT_TRUE(is_alike({{kCalm, "calm", 0.8, 0.1, 0.5}, {kRough, "rough", 1.3, 0.1, 0.5}}));
  EXPECT_FALSE(is_alike({{kCalm, "calm", 0.6, 0.1, 0.5}, {kRough, "rough", 1.8, 0.1, 0.5}}));
  EXPECT_TRUE(is_alike({{kCalm, "calm", 0.6, 0.45, 0.5}, {kRough, "rough", 1.8, 0.45, 0.5}}));  // by chance
}

// Deviation of an effect's size in the second phase, which has so many blocks of half a second.
double find_deviation(int blocks) {
  const ColumnLayout layout(make_legged_log(make_biped({}), Half::kEven));
  std::mt19937 random(47);
  std::normal_distribution<double> normal;
  RowTable even(layout.count()), odd(layout.count());
  for (RowTable* half : {&even, &odd}) half->add_channel(kWeight, {0});
  double of_block = 0;
  for (int i = 0; i < 960; ++i) {
    if (i % 12 == 0) of_block = normal(random);
    for (RowTable* half : {&even, &odd}) {
      half->begin_cell({0.04 * i, 0, i / 12, i / 12 < blocks ? 2 : 1, true, 1, get_mixed_roughness(i)});
      half->begin_row(0, 10 + of_block, 100);
      half->add(0, 0, 1);
      half->end_cell();
    }
  }
  even.finish();
  odd.finish();
  LeggedFitter fitter(merge_halves(even, odd), layout.count());
  const Candidate constant = make_candidate(EffectId::kSensorBias, "", {{{0, 1.0}}});
  for (const Regime& r : list_regimes(fitter, fitter.fit({constant}), 0, layout)) {
    if (r.name == "phase 2") return r.std;
  }
  return 0;
}

// The scatter of the same five blocks, with Student's quantile for four degrees of freedom.
TEST(LeggedRegimes, APhaseOfAFewBlocksTellsLess) {
  const double few = find_deviation(5);
  EXPECT_GT(few * std::sqrt(5) / 0.1, 1.4);  // errors of 0.1 of the size, by block; 1.6 times more by Student
  EXPECT_LT(find_deviation(60) * std::sqrt(60) / 0.1, 1.3);
}

}  // namespace
}  // namespace hrp::diagnosis::floating
