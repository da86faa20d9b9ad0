// SPDX-License-Identifier: BSD-3-Clause
// A hand that holds a robot: a spring and a damper to a place that moves.
#include "common/robot/hand.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/base/diagnostics.h"
#include "servers/dynamics/engine.h"
#include "tests/physics/rigs.h"

namespace hrp {
namespace {

using ::testing::HasSubstr;

TEST(HandLaw, PullsThePointTowardsTheHandAxisByAxis) {
  HandSpec hand;
  hand.stiffness_W = {100.0, 200.0, 0.0};
  hand.damping_W = {10.0, 0.0, 5.0};
  const Vector3d force = calc_hand_force(hand, {0.1, -0.2, 0.3}, {1.0, 1.0, -2.0});
  EXPECT_TRUE(force.isApprox(Vector3d(100.0 * 0.1 + 10.0, -40.0, -10.0)));
}

TEST(HandLaw, GoesFromPointToPointAndItsVelocityIsTheDerivativeOfItsPlace) {
  HandSpec hand;
  hand.path = {{1.0, {0, 0, 0}}, {3.0, {0.1, 0, 0}}, {4.0, {0.1, -0.2, 0}}};
  hand.waves = {{{0, 0.02, 0}, 0.7, 0.4, 2.0, 6.0, 1.5}, {{0.01, 0, 0.01}, 1.3, 0.0, 0.5, 0.0, 0.5}};
  EXPECT_TRUE(calc_hand_place(hand, 0.3).p.isZero());
  HandSpec still = hand;
  still.waves.clear();
  EXPECT_TRUE(calc_hand_place(still, 2.0).p.isApprox(Vector3d(0.05, 0, 0)));  // half the time, half the way
  EXPECT_TRUE(calc_hand_place(still, 9.0).p.isApprox(Vector3d(0.1, -0.2, 0)));
  EXPECT_TRUE(calc_hand_place(still, 9.0).v.isZero());
  const double h = 1e-5;
  for (double t = 0.05; t < 9.0; t += 0.1) {
    const Vector3d v = (calc_hand_place(hand, t + h).p - calc_hand_place(hand, t - h).p) / (2.0 * h);
    // Central differences: h^2 times a third derivative of at most 100 m/s^3.
    EXPECT_LT((calc_hand_place(hand, t).v - v).norm(), 1e-7) << t;
  }
}

// A free body, held at its centre of mass, where there is no weight.
struct Held {
  explicit Held(const std::string& hand, double mass = 2.0)
      : robot(rigs::make_body(rigs::make_box_inertia(mass, {0.2, 0.2, 0.2}))),
        scenario(parse_scenario("robot: body.urdf\ngravity: [0, 0, 0]\nground: {type: none}\nhands: {person: " + hand +
                                    "}\nsteps: {time_step: 0.0005, control_period: 0.005}\n",
                                "held.yaml")) {
    robot.tree.floating_base = true;
  }
  RobotDescription robot;
  Scenario scenario;
};

TEST(Hand, SwingsAFreeBodyAsASpringAndDamperDo) {
  const Held held("{link: body, stiffness: 50, damping: 2, path: [{time: 0, xyz: [0.1, 0, 0]}]}");
  SimulatorEngine engine(held.robot, held.scenario);
  const double m = 2.0, k = 50.0, c = 2.0, decay = c / (2.0 * m), w = std::sqrt(k / m - decay * decay), dt = 0.0005;
  for (int i = 1; i <= 4000; ++i) {
    ASSERT_EQ(engine.step({}, {}), "");
    const double t = i * dt, x = 0.1 * (1.0 - std::exp(-decay * t) * (std::cos(w * t) + decay / w * std::sin(w * t)));
    // First order in the step: half a step of the largest velocity, 0.1 w dt / 2.
    ASSERT_NEAR(engine.state().p_WB.x(), x, 2e-4) << t;
  }
}

// Held away from the centre of mass it turns the body, too; equal inputs give equal bits, also after a reset.
TEST(Hand, TakesHoldWhereThePointIsAndStartsAfreshOnReset) {
  const Held held(
      "{link: body, xyz: [0, 0.1, 0], stiffness: [80, 80, 0], damping: 1, start: 0.1, duration: 0.3, "
      "waves: [{amplitude: [0.05, 0, 0], frequency: 1.5, fade: 0.1}]}");
  SimulatorEngine engine(held.robot, held.scenario);
  std::vector<Vector3d> first;
  for (int round = 0; round < 2; ++round) {
    for (int i = 0; i < 1000; ++i) {
      ASSERT_EQ(engine.step({}, {}), "");
      if (i < 199) {
        ASSERT_TRUE(engine.state().V_WB.isZero()) << "not yet held";
      }
      if (round == 0) first.push_back(engine.state().p_WB);
      ASSERT_EQ(engine.state().p_WB, first[static_cast<size_t>(i)]);
    }
    EXPECT_GT(std::abs(engine.state().V_WB[2]), 0.01) << "yaw";
    const Vector6d V = engine.state().V_WB;
    ASSERT_EQ(engine.step({}, {}), "");
    EXPECT_NEAR((engine.state().V_WB - V).tail<3>().norm(), 0.0, 1e-12) << "let go";
    engine.reset();
  }
}

TEST(Hand, ThatIsTooStiffForAStepIsRefused) {
  const Held held("{link: body, stiffness: 1000, damping: 5000}");
  try {
    SimulatorEngine engine(held.robot, held.scenario);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("held.yaml:4"));
    EXPECT_THAT(error.what(), HasSubstr("hands.person: is too stiff for a link of 2"));
  }
}

TEST(Hand, OnALinkThatIsNotThereIsRefused) {
  const Held held("{link: trunk, stiffness: 100}");
  EXPECT_THROW(SimulatorEngine(held.robot, held.scenario), InputError);
}

}  // namespace
}  // namespace hrp
