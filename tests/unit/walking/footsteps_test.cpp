// SPDX-License-Identifier: BSD-3-Clause
// Plans that can be walked, and those that are refused with the step and the reason.
#include "controller/walking/footsteps.h"

#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/diagnostics.h"
#include "controller/walking/pattern.h"
#include "tests/catch_complaint.h"

namespace hrp::walking {
namespace {

Stance make_stance() {
  Stance stance;
  stance.feet[kLeft].p = {0.0, 0.095, 0.0};
  stance.feet[kRight].p = {0.0, -0.095, 0.0};
  return stance;
}

FootstepSpec step(double x, double y, double theta = 0.0, const std::string& frame = "support") {
  FootstepSpec spec;
  spec.frame = frame;
  spec.x = x;
  spec.y = y;
  spec.theta = theta;
  return spec;
}

std::string get_refusal(const std::vector<FootstepSpec>& steps) {
  WalkSpec spec;
  spec.footsteps = steps;
  return catch_complaint([&] { make_footsteps(spec, make_stance(), {}); });
}

TEST(Footsteps, ForwardEndsSideBySideOneStepLengthAStep) {
  WalkSpec spec;
  spec.count = 5;
  spec.length = 0.2;
  const auto steps = make_footsteps(spec, make_stance(), {});
  ASSERT_EQ(steps.size(), 6u);
  for (size_t i = 0; i < 5; ++i) EXPECT_NEAR(steps[i].hold.p.x(), 0.2 * (i + 1), 1e-12);
  EXPECT_NEAR(steps[5].hold.p.x(), steps[4].hold.p.x(), 1e-12);
  EXPECT_NEAR(std::abs(steps[5].hold.p.y() - steps[4].hold.p.y()), 0.19, 1e-12);
}

TEST(Footsteps, TurningAndSidewaysStayWithinWhatLegsCanDo) {
  WalkSpec turning;
  turning.count = 6;
  turning.turn = 0.25;
  EXPECT_NEAR(make_footsteps(turning, make_stance(), {}).back().hold.yaw, 1.5, 1e-12);
  WalkSpec sideways;
  sideways.count = 6;
  sideways.side = 0.05;
  sideways.first = "left";
  EXPECT_NEAR(make_footsteps(sideways, make_stance(), {}).back().hold.p.y(), 0.3 - 0.095 + 0.19, 1e-9);
}

TEST(Footsteps, OnASlopeLieOnItsPlane) {
  WalkSpec spec;
  spec.count = 3;
  spec.length = 0.2;
  for (const Footstep& s : make_footsteps(spec, make_stance(), {0.05, -0.02})) {
    EXPECT_NEAR(s.hold.p.z(), 0.05 * s.hold.p.x() - 0.02 * (s.hold.p.y() - 0.095), 3e-3)
        << "from the first feet's height";
  }
}

TEST(Footsteps, BadPlansAreRefusedWithTheStepAndTheReason) {
  using ::testing::HasSubstr;
  EXPECT_EQ(get_refusal({step(0.2, -0.19), step(0.2, 0.19)}), "");
  EXPECT_THAT(get_refusal({step(0.2, -0.19), step(0.6, 0.19)}), HasSubstr("step 2 (left): too long: 0.600 m"));
  EXPECT_THAT(get_refusal({step(0.2, 0.05)}), HasSubstr("step 1 (right): crossing legs"));
  EXPECT_THAT(get_refusal({step(0.2, -0.19), step(0.0, 0.19, 0.0, "map")}),
              HasSubstr("step 2 (left): unknown frame 'map'"));
  EXPECT_THAT(get_refusal({step(0.0, -0.19, 1.2)}), HasSubstr("turns too far: 1.200 rad"));
  EXPECT_THAT(get_refusal({step(0.0, -0.6)}), HasSubstr("too wide"));
  EXPECT_THAT(get_refusal({step(NAN, -0.19)}), HasSubstr("not finite"));
  FootstepSpec again = step(0.0, -0.19);
  again.side = "right";
  EXPECT_THAT(get_refusal({again, again}), HasSubstr("step 2 (right): the same foot twice"));
}

PatternStart make_start() {
  PatternStart start;
  start.com = {0.0, 0.0, 0.8};
  for (int side : {kLeft, kRight}) start.soles[side].p = make_stance().feet[side].p;
  return start;
}

TEST(WalkPattern, IsContinuousObeysThePendulumAndEndsAtRest) {
  WalkSpec spec;
  spec.count = 6;
  spec.length = 0.2;
  const WalkPattern pattern(spec, make_start(), 0.8);
  constexpr double h = 1e-3;
  for (double t = h; t < pattern.duration() + 0.5; t += h) {
    const PatternSample a = pattern.sample(t - h), b = pattern.sample(t);
    ASSERT_LT((b.com - a.com - 0.5 * h * (a.com_velocity + b.com_velocity)).norm(), 1e-5) << t << " s";
    ASSERT_LT((b.zmp - a.zmp).norm(), 0.01) << t << " s: 10 m/s, a whole stance within the double support";
    for (int side : {0, 1}) ASSERT_LT((b.soles[side].p - a.soles[side].p).norm(), 0.005) << t << " s: 5 m/s";
  }
  const PatternSample end = pattern.sample(pattern.duration() + 1.0);
  EXPECT_LT(end.com_velocity.norm(), 1e-3) << "what is left decays within 0.3 s";
  EXPECT_LT((end.com - end.zmp).head<2>().norm(), 1e-3);
}

TEST(WalkPattern, PlacedFeetAreNearThePlanAndSwingFeetLandOnThem) {
  WalkSpec spec;
  spec.count = 8;
  spec.length = 0.2;
  const WalkPattern pattern(spec, make_start(), 0.8);
  for (size_t i = 0; i < pattern.footsteps().size(); ++i) {
    const Vector3d moved = pattern.footsteps()[i].hold.p - pattern.planned()[i].hold.p;
    EXPECT_LT(moved.norm(), 0.06) << "step " << i + 1 << ": starting and stopping move a foot by a quarter of a step";
  }
  const PatternSample end = pattern.sample(pattern.duration());
  const Footstep& last = pattern.footsteps().back();
  EXPECT_LT((end.soles[last.side].p - last.hold.p).norm(), 1e-12);
}

TEST(StepAdjustment, TheFootInTheAirAndAllThatFollowsMoveTheStandingFootDoesNot) {
  WalkSpec spec;
  spec.count = 6;
  spec.length = 0.2;
  const WalkPattern plan(spec, make_start(), 0.8);
  WalkPattern pattern(spec, make_start(), 0.8);
  double t = 0.0;
  while (plan.sample(t).step < 3) t += 0.005;  // the third step: right foot in the air
  t += 0.3;
  const Vector2d shift(0.05, -0.03);
  ASSERT_TRUE(pattern.move_step(t, shift));
  EXPECT_LT((pattern.sample(t).soles[kLeft].p - plan.sample(t).soles[kLeft].p).norm(), 1e-12);
  for (double later : {t + pattern.find_remaining(t) + 1e-6, pattern.duration()}) {
    const PatternSample a = plan.sample(later), b = pattern.sample(later);
    EXPECT_LT(((b.soles[kRight].p - a.soles[kRight].p).head<2>() - shift).norm(), 1e-12) << later << " s";
    EXPECT_LT((b.shift - shift).norm(), 1e-12);
  }
  const PatternSample a = plan.sample(pattern.duration()), b = pattern.sample(pattern.duration());
  EXPECT_LT(((b.soles[kLeft].p - a.soles[kLeft].p).head<2>() - shift).norm(), 1e-12);
  EXPECT_LT(((b.zmp - a.zmp).head<2>() - shift).norm(), 1e-12);
}

TEST(StepAdjustment, FootholdsStayWithinReachAndLegsNeverCross) {
  WalkSpec spec;
  spec.count = 6;
  spec.length = 0.2;
  WalkPattern pattern(spec, make_start(), 0.8);
  double t = 0.0;
  while (pattern.sample(t).step < 3) t += 0.005;
  for (const Vector2d& shift : {Vector2d(0.0, 2.0), Vector2d(0.0, -2.0), Vector2d(2.0, 0.5), Vector2d(-2.0, 0.0)}) {
    ASSERT_TRUE(pattern.move_step(t, shift));
    const PatternSample s = pattern.sample(t + pattern.find_remaining(t) + 1e-6);
    const Vector3d d = s.soles[kLeft].p - s.soles[kRight].p;  // the feet have no heading here
    EXPECT_LE(std::abs(d.x()), spec.max_length + 1e-12);
    EXPECT_GE(d.y(), spec.min_width - 1e-12);
    EXPECT_LE(d.y(), spec.max_width + 1e-12);
  }
  EXPECT_FALSE(pattern.move_step(0.1, {0.1, 0.0})) << "before the walk";
  EXPECT_FALSE(pattern.move_step(pattern.duration(), {0.1, 0.0})) << "after it";
}

TEST(SwingFoot, RisesToItsHeightAndLandsAtItsSpeed) {
  const double T = 0.7;
  EXPECT_NEAR(calc_swing_height(0.5, T, 0.05, 0.2), 0.05, 1e-12);
  EXPECT_EQ(calc_swing_height(1.0, T, 0.05, 0.2), 0.0);
  const double speed = calc_swing_height(1.0 - 1e-6, T, 0.05, 0.2) / (1e-6 * T);
  EXPECT_NEAR(speed, 0.2, 1e-3) << "one-sided difference";
}

}  // namespace
}  // namespace hrp::walking
