// SPDX-License-Identifier: BSD-3-Clause
// Where no set of effects explains recordings, the one effect that takes nearly all of the error is said.
#include <gtest/gtest.h>

#include "diagnosis/search/outcome.h"

namespace hrp::diagnosis {
namespace {

Trial make_trial(const Hypothesis& hypothesis, double rms) {
  Trial trial;
  trial.hypothesis = hypothesis, trial.rms = rms;
  return trial;
}

// A hobby servo's step, 445 times the noise beside a model without friction.
Outcome make_step(double viscous) {
  const Effect drag{EffectId::kViscous, 0, {0.028}}, curve{EffectId::kStribeck, 0, {0.01, 0.01, 0.1, 0.028}}, dry{EffectId::kCoulomb, 0, {0.3, 0.0, 5e-4}};
  Outcome outcome;
  outcome.nominal = make_trial({}, 445.0);
  outcome.rivals = {make_trial({curve}, 0.98 * viscous), make_trial({drag}, viscous), make_trial({drag, dry}, 0.5 * viscous), make_trial({dry}, 38.0)};
  return outcome;
}

TEST(ClosestEffect, IsTheSimplestOfThoseThatTakeNearlyAllOfTheHeldOutError) {
  const Outcome step = make_step(4.9);
  const Trial* closest = find_closest(step);
  ASSERT_TRUE(closest);
  ASSERT_EQ(closest->hypothesis.size(), 1u);
  EXPECT_EQ(closest->hypothesis[0].id, EffectId::kViscous);
}

TEST(ClosestEffect, IsNoneWhereMoreThanATwentiethIsLeft) { EXPECT_FALSE(find_closest(make_step(30.0))); }

}  // namespace
}  // namespace hrp::diagnosis
