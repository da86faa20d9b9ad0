// SPDX-License-Identifier: BSD-3-Clause
// Where no set of effects explains recordings, the fewest effects that take nearly all of the error are said.
#include <gtest/gtest.h>

#include "diagnosis/search/outcome.h"

namespace hrp::diagnosis {
namespace {

Trial make_trial(const Hypothesis& hypothesis, double rms) {
  Trial trial;
  trial.hypothesis = hypothesis;
  trial.rms = rms;
  trial.refined = true;
  return trial;
}

// A hobby servo's step, 445 times the noise beside a model without friction.
Outcome make_step(double viscous) {
  const Effect drag{EffectId::kViscous, 0, {0.028}}, curve{EffectId::kStribeck, 0, {0.01, 0.01, 0.1, 0.028}},
      dry{EffectId::kCoulomb, 0, {0.3, 0.0, 5e-4}};
  Outcome outcome;
  outcome.nominal = make_trial({}, 445.0);
  outcome.rivals = {make_trial({curve}, 0.98 * viscous), make_trial({drag}, viscous),
                    make_trial({drag, dry}, 0.5 * viscous), make_trial({dry}, 138.0)};
  return outcome;
}

TEST(ClosestEffect, IsTheSimplestOfThoseThatTakeNearlyAllOfTheHeldOutError) {
  const Outcome step = make_step(4.9);
  const Trial* closest = find_closest(step);
  ASSERT_TRUE(closest);
  ASSERT_EQ(closest->hypothesis.size(), 1u);
  EXPECT_EQ(closest->hypothesis[0].id, EffectId::kViscous);
}

TEST(ClosestEffect, IsNoneWhereMoreThanATenthIsLeft) { EXPECT_FALSE(find_closest(make_step(100.0))); }

// Friction and a late command: neither takes nearly all alone.
TEST(ClosestEffects, ArePairedWhereNoneTakesNearlyAllAlone) {
  const Effect drag{EffectId::kViscous, 0, {0.4}}, curve{EffectId::kStribeck, 0, {0.01, 0.01, 0.1, 0.4}},
      late{EffectId::kDelay, 0, {0.03}};
  const Effect pull{EffectId::kSpring, 0, {0.3, 0.0}}, dry{EffectId::kCoulomb, 0, {0.3, 0.0, 5e-4}};
  Outcome outcome;
  outcome.nominal = make_trial({}, 110.0);
  outcome.rivals = {make_trial({drag, late, pull}, 5.0), make_trial({drag, late}, 11.2),
                    make_trial({curve, late}, 10.8), make_trial({drag, dry}, 25.0), make_trial({drag}, 24.0)};
  Trial on_path = make_trial({drag, pull}, 3.0);  // along the recorded path only: the motion was not simulated
  on_path.refined = false;
  outcome.rivals.push_back(on_path);
  const Trial* closest = find_closest(outcome);
  ASSERT_TRUE(closest);
  EXPECT_EQ(make_set(closest->hypothesis), make_set({drag, late}));
  const std::vector<const Trial*> others = list_as_close(outcome, *closest);
  ASSERT_EQ(others.size(), 1u);
  EXPECT_EQ(make_set(others[0]->hypothesis), make_set({curve, late}));
}

}  // namespace
}  // namespace hrp::diagnosis
