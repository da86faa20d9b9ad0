// SPDX-License-Identifier: BSD-3-Clause
// Tossed bodies: the prediction against closed forms, and hidden friction and restitution found again.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "diagnosis/toss/search.h"
#include "diagnosis/toss/strikes.h"

namespace hrp::diagnosis::toss {
namespace {

constexpr double kEdge = 0.1;    // [m]
constexpr double kNoise = 5e-5;  // [m]; attitudes 5e-4 rad

RobotDescription make_body(ShapeKind kind) {
  RobotDescription robot;
  LinkSpec link;
  link.name = "body";
  link.inertia.mass = 0.4;
  link.inertia.I_LLcm_L = 0.4 * kEdge * kEdge / 6.0 * Matrix3d::Identity();
  robot.tree.name = "tossed";
  robot.tree.links = {link};
  CollisionShape shape;
  shape.kind = kind;
  shape.sole = true;
  shape.size = kind == ShapeKind::kBox ? Vector3d::Constant(kEdge) : Vector3d(kEdge / 2, 0, 0);
  robot.shapes = {shape};
  return robot;
}

World make_world(const RobotDescription& robot, double friction, double restitution) {
  World world;
  world.body = robot.tree;
  world.ground.friction = friction;
  world.restitution = restitution;
  return world;
}

std::vector<double> make_times(double duration, double step) {
  std::vector<double> times;
  for (int k = 0; k * step <= duration; ++k) times.push_back(k * step);
  return times;
}

TEST(TossedBody, RisesAgainToTheSquareOfTheRestitution) {
  const RobotDescription robot = make_body(ShapeKind::kSphere);
  BodyState start;
  start.p_WB.z() = kEdge / 2 + 0.2;
  std::vector<BodyState> states;
  ASSERT_TRUE(roll_out(make_world(robot, 0.5, 0.5), make_soles(robot), start, make_times(0.42, 0.002), &states));
  double highest = 0.0;
  for (size_t k = 110; k < states.size(); ++k) highest = std::max(highest, states[k].p_WB.z() - kEdge / 2);
  EXPECT_NEAR(highest, 0.25 * 0.2, 2e-4);  // the touch is found to 20 um, samples stand 2 ms apart
}

TEST(TossedBody, LosesSpeedAtFrictionTimesGravityWhileItSlides) {
  const RobotDescription robot = make_body(ShapeKind::kBox);
  BodyState start;
  start.p_WB.z() = kEdge / 2;
  start.v_WB.x() = 1.0;
  std::vector<BodyState> states;
  ASSERT_TRUE(roll_out(make_world(robot, 0.2, 0.0), make_soles(robot), start, make_times(0.2, 0.01), &states));
  EXPECT_NEAR(states.back().v_WB.x(), 1.0 - 0.2 * 9.81 * 0.2, 2e-3);  // first contact step may still settle
  EXPECT_NEAR(states.back().p_WB.x(), 0.2 - 0.5 * 0.2 * 9.81 * 0.04, 1e-3);
}

struct Truth {
  double friction, restitution;
  double inertia = 1.0, lengths = 1.0;    // moments of inertia and recorded lengths over the model's
  double height = 0.12, duration = 0.38;  // [m], [s] of a toss
};

Experiment make_experiment(const Truth& world, int tosses) {
  Experiment e;
  e.robot = make_body(ShapeKind::kBox);
  e.scenario.floating_base = true;
  e.scenario.ground.friction = 0.5;
  e.sample_time = 0.008;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  World truth = make_world(e.robot, world.friction, world.restitution);
  truth.body.links[0].inertia.I_LLcm_L *= world.inertia;
  for (int t = 0; t < tosses; ++t) {
    BodyState start;
    start.R_WB = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
    start.p_WB.z() = world.height;
    start.v_WB = Vector3d(0.8, 0.3 * normal(random), -0.5);
    start.w_WB = Vector3d(normal(random), 3.0 * normal(random), normal(random));
    Recording r;
    r.spec.name = "toss";
    r.spec.train = t + 1 < tosses;
    r.time = make_times(world.duration, e.sample_time);
    std::vector<BodyState> states;
    EXPECT_TRUE(roll_out(truth, make_soles(e.robot), start, r.time, &states));
    for (const BodyState& s : states) {
      const Vector3d turn = 10.0 * kNoise * Vector3d(normal(random), normal(random), normal(random));
      const Eigen::Quaterniond R = Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized())) * s.R_WB;
      const char* const names[] = {"x", "y", "z", "w"};
      for (int i = 0; i < 4; ++i) {
        if (i < 3)
          r.other[std::string("/base/pose/position/") + names[i]].push_back(world.lengths * s.p_WB[i] +
                                                                            kNoise * normal(random));
        r.other[std::string("/base/pose/orientation/") + names[i]].push_back(R.coeffs()[i]);
      }
    }
    e.recordings.push_back(r);
  }
  return e;
}

TEST(TossedBody, FrictionAndRestitutionComeBack) {
  const Experiment e = make_experiment({0.2, 0.3}, 5);
  TossProblem problem;
  std::string why;
  ASSERT_TRUE(make_toss_problem(e, &problem, &why)) << why;
  Hypothesis start{make_neutral(problem, EffectId::kGroundFriction), make_neutral(problem, EffectId::kRestitution)};
  start[0].p[0] = 0.3;
  start[1].p[0] = 0.2;
  const TossFit nominal = fit_starts(problem, {}, nullptr, 1);
  const TossFit fit = fit_tosses(problem, fit_starts(problem, start, nullptr, 1), {});
  EXPECT_NEAR(fit.hypothesis[0].p[0], 0.2, 0.05 * 0.2);
  EXPECT_NEAR(fit.hypothesis[1].p[0], 0.3, 0.05 * 0.3);
  EXPECT_LT(fit.train, 0.2 * nominal.train);
}

TEST(TossedBody, NothingIsMissingWhenNothingIsHidden) {
  const Experiment e = make_experiment({0.5, 0.0}, 3);
  TossProblem problem;
  std::string why;
  ASSERT_TRUE(make_toss_problem(e, &problem, &why)) << why;
  const TossFit nominal = fit_starts(problem, {}, nullptr, 1);
  EXPECT_LT(nominal.train, 1.2);  // the score from which on a mismatch is reported
}

// Of the held-out toss every third pose was logged: no window is left, and its misfit of zero is no agreement.
TEST(TossedBody, AHeldOutTossWithoutAWindowExcusesNothing) {
  Experiment e = make_experiment({0.05, 0.6}, 3);
  Recording& held_out = e.recordings.back();
  const auto thin = [](std::vector<double>* values) {
    for (size_t k = 0; 3 * k < values->size(); ++k) (*values)[k] = (*values)[3 * k];
    values->resize((values->size() + 2) / 3);
  };
  thin(&held_out.time);
  for (auto& column : held_out.other) thin(&column.second);
  TossProblem problem;
  std::string why;
  ASSERT_TRUE(make_toss_problem(e, &problem, &why)) << why;
  ASSERT_EQ(problem.notes.size(), 1u);
  EXPECT_EQ(problem.notes[0], "toss: not used, as it has no 8 poses in a row without a gap");
  EXPECT_TRUE(search_tosses(problem, 1, nullptr).mismatch);
}

TossProblem make_problem(const Experiment& e) {
  TossProblem problem;
  std::string why;
  EXPECT_TRUE(make_toss_problem(e, &problem, &why)) << why;
  return problem;
}

TEST(TossedBody, StrikesOfOneCornerTellItsInertiaWhateverTheLawOfContact) {
  for (const double friction : {0.1, 0.6}) {
    for (const double restitution : {0.1, 0.5}) {
      const Experiment e = make_experiment({friction, restitution, 1.3}, 40);
      const auto inertia = measure_inertia(make_problem(e));
      ASSERT_TRUE(inertia) << friction << " " << restitution;
      EXPECT_NEAR(inertia->value, 1.3, 0.04) << friction << " " << restitution;  // strikes of other points within 40 ms
      EXPECT_GT(inertia->value - 1.0, 3.0 * inertia->std);
    }
  }
}

TEST(TossedBody, FallAndHeightOfRestTellAScaleOfLengths) {
  const Experiment e = make_experiment({0.5, 0.1, 1.0, 0.97, 0.25, 1.2}, 12);
  const TossProblem problem = make_problem(e);
  const auto fall = measure_fall(problem), height = measure_rest_height(problem);
  ASSERT_TRUE(fall && height);
  EXPECT_NEAR(fall->value, 0.97, 3.0 * fall->std);
  EXPECT_LT(fall->std, 0.005);
  EXPECT_NEAR(height->value, -0.03 * kEdge / 2, 1e-4);  // noise of a pose 50 um
}

TEST(TossedBody, AnInertiaIsNamedWhereStrikesMeasureIt) {
  const Experiment e = make_experiment({0.5, 0.4, 1.3}, 16);
  const TossOutcome outcome = search_tosses(make_small_problem(make_problem(e), 60), 2, nullptr);
  const Hypothesis& found = outcome.chosen.hypothesis;
  ASSERT_EQ(found.size(), 2u);
  for (const Effect& effect : found) {
    const bool is_inertia = effect.id == EffectId::kInertiaError;
    EXPECT_TRUE(is_inertia || effect.id == EffectId::kRestitution);
    EXPECT_NEAR(effect.p[0], is_inertia ? 1.3 : 0.4, 0.03);  // a twentieth of what is hidden and more
    EXPECT_GT(outcome.shares.at(effect.id), 0.0);
  }
}

}  // namespace
}  // namespace hrp::diagnosis::toss
