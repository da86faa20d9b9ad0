// SPDX-License-Identifier: BSD-3-Clause
// The contact law of pairs, [H03 eq. 1 to 6] as the paper writes it, equation by equation and in a simulation.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/base/diagnostics.h"
#include "servers/dynamics/wrench_law.h"
#include "tests/physics/rigs.h"
#include "tests/physics/solutions/contact_solutions.h"

namespace hrp {
namespace {

const Vector3d kCorners[4] = {{0.12, 0.06, 0}, {0.12, -0.06, 0}, {-0.12, 0.06, 0}, {-0.12, -0.06, 0}};

Vector6d make6(double a, double b, double c, double d, double e, double f) {
  Vector6d x;
  x << a, b, c, d, e, f;
  return x;
}

WrenchLaw make_law() {
  WrenchLaw law;
  law.stiffness = make6(300, 400, 700, 2e5, 2e5, 3e5);
  law.damping = make6(10, 20, 30, 1000, 2000, 3000);
  law.alpha = 2.0;
  law.exponent = 1.5;
  law.length = 0.1;
  return law;
}

// Corners of a sole that is displaced by D from lying on the floor.
std::vector<PairPoint> make_points(const Vector6d& D) {
  std::vector<PairPoint> points;
  for (const Vector3d& r : kCorners) {
    points.push_back({r, Vector3d::UnitZ(), -(D.tail<3>() + Vector3d(D.head<3>()).cross(r)).z()});
  }
  return points;
}

PairDisplacement find(const WrenchLaw& law, const std::vector<PairPoint>& points) {
  return calc_pair_displacement(law, points.data(), static_cast<int>(points.size()));
}

TEST(PairDisplacement, IsThatOfASoleSunkInAndTiltedAlsoWhereACornerIsAboveTheFloor) {
  for (const Vector6d& D :
       {make6(0, 0, 0, 0, 0, -1e-3), make6(2e-3, -1e-3, 0, 0, 0, -1e-3), make6(0, 20e-3, 0, 0, 0, -1e-3)}) {
    EXPECT_LT((find(make_law(), make_points(D)).D - D).norm(), 1e-9)
        << D.transpose();  // Hildreth's rest: 1e-12 of 2 mm
  }
}

TEST(PairDisplacement, MakesASpringWrenchOfForcesThatPushAtThePoints) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> depth(-2e-3, 2e-3);
  for (int trial = 0; trial < 100; ++trial) {
    std::vector<PairPoint> points;
    for (const Vector3d& r : kCorners) points.push_back({r, Vector3d::UnitZ(), depth(random)});
    const PairDisplacement found = find(make_law(), points);
    Vector6d sum = Vector6d::Zero();
    for (size_t i = 0; i < points.size(); ++i) {
      EXPECT_GE(found.force[i], 0.0);
      sum.head<3>() += found.force[i] * points[i].r.cross(points[i].n);
      sum.tail<3>() += found.force[i] * points[i].n;
      const double gap = (-found.D.tail<3>() - Vector3d(found.D.head<3>()).cross(points[i].r)).z() - points[i].depth;
      EXPECT_GT(gap, -1e-9) << "moved by -D the bodies are apart at every point";
    }
    EXPECT_LT((calc_spring_wrench(make_law().stiffness, found.D) - sum).norm(), 1e-6 * sum.norm() + 1e-9);
  }
}

TEST(PairDisplacement, HasTheSlopeOfItsSpringWrench) {
  const WrenchLaw law = make_law();
  for (const Vector6d& D :
       {make6(0, 0, 0, 0, 0, -1e-3), make6(0, 0.15, 0, 0, 0, -1e-3)}) {  // on four corners, on an edge
    const PairDisplacement found = find(law, make_points(D));
    for (int i = 0; i < 6; ++i) {
      const Vector6d step = 1e-7 * Vector6d::Unit(i);
      const Vector6d change = calc_spring_wrench(law.stiffness, find(law, make_points(D + step)).D) -
                              calc_spring_wrench(law.stiffness, found.D);
      EXPECT_LT((change + found.slope * step).norm(), 1e-4) << i;  // [N] of up to 0.03
    }
  }
}

TEST(PairLaw, SpringIsMinusKTimesTheDisplacementInAllSix) {
  const Vector6d F = calc_spring_wrench(make_law().stiffness, make6(1e-3, -2e-3, 3e-3, 1e-4, -2e-4, -1e-3));
  EXPECT_LT((F - make6(-0.3, 0.8, -2.1, -20, 40, 300)).norm(), 1e-12);
}

TEST(PairLaw, DamperGrowsWithThePowerOfEachTranslationAndRotation) {
  const Vector6d D = make6(4e-4, -4e-4, 0, 0, 0, -1e-4), V = make6(0.1, 0.2, 0.3, 0.1, 0.2, -0.3);
  const Vector6d F = calc_damping_wrench(make_law(), D, V);
  // lambda = 3/2 alpha K = 3 K; 4e-4^1.5 = 8e-6, 1e-4^1.5 = 1e-6.
  EXPECT_LT((F - make6(-900 * 8e-6 * 0.1, -1200 * 8e-6 * 0.2, 0, 0, 0, 9e5 * 1e-6 * 0.3)).norm(), 1e-12);
}

TEST(PairLaw, NormalWrenchIsSpringAndDamperTogether) {
  const Vector6d F = calc_normal_wrench(make6(1, 2, 3, 4, 5, 6), make6(10, 20, 30, 40, 50, 60));
  EXPECT_EQ(F, make6(11, 22, 33, 44, 55, 66));
}

TEST(PairLaw, TangentialDamperLeavesOutWhatIsAlongTheNormalWrench) {
  const WrenchLaw law = make_law();
  // A pure force along z: the other five are damped by C, z is not.
  const Vector6d V = make6(0.1, 0.2, 0.3, 0.4, 0.5, 0.6);
  EXPECT_LT((calc_tangential_wrench(law, make6(0, 0, 0, 0, 0, 500), V) - make6(-1, -4, -9, -400, -1000, 0)).norm(),
            1e-9);
  // A force beside Q: orthogonal in six dimensions, moments over the length; never feeds energy in.
  const Vector6d normal = make6(20, -30, 0, 5, 0, 500), F = calc_tangential_wrench(law, normal, V);
  const auto scale = [&](Vector6d x) {
    x.head<3>() /= law.length;
    return x;
  };
  EXPECT_LT(std::abs(scale(F).dot(scale(normal))), 1e-9 * F.norm() * normal.norm());
  EXPECT_LT(F.dot(V), -1.0);
  EXPECT_EQ(calc_tangential_wrench(law, Vector6d::Zero(), V), Vector6d(Vector6d::Zero()));
}

TEST(PairLaw, ClipsTheNormOfTheWholeTangentialWrench) {
  const Vector6d normal = make6(0, 0, 0, 0, 0, 100);
  Vector6d F = make6(0, 0, 4, 30, 0, 0);  // 4 N m over 0.1 m are 40 N: 50 N in all
  EXPECT_FALSE(clip_wrench(0.51, 0.1, normal, &F));
  EXPECT_TRUE(clip_wrench(0.25, 0.1, normal, &F));
  EXPECT_LT((F - make6(0, 0, 2, 15, 0, 0)).norm(), 1e-12);
  EXPECT_TRUE(clip_wrench(0.25, 0.1, Vector6d::Zero(), &F));
  EXPECT_EQ(F.norm(), 0.0);
}

// A block on the ground under `contact.model: wrench`.
struct Block {
  double mass = 12.0;
  Vector3d half = Vector3d(0.10, 0.06, 0.05);
  RobotDescription robot = rigs::make_body(rigs::make_box_inertia(mass, 2.0 * half));
  Scenario scenario = rigs::make_scenario();
  rigs::CornerFinder finder;
  double slope = 0.0;  // [rad] about y

  Block() {
    finder.add_box(0, half);
    finder.margin = 0.02;
    scenario.contact.model = "wrench";
    scenario.contact.stiffness = 1e6;
    scenario.contact.tangential_damping = 2e4;
  }
  Simulator make() {
    finder.n = Eigen::AngleAxisd(slope, Vector3d::UnitY()) * Vector3d::UnitZ();
    scenario.initial_rpy = Vector3d(0, slope, 0);
    scenario.initial_position = (half.z() - 1e-4) * finder.n;
    return Simulator(robot, scenario);
  }
  void run(Simulator* simulator, int steps, const ExternalWrenches& pushes = {}) {
    const Model model(simulator->tree());
    for (int i = 0; i < steps; ++i) {
      ASSERT_EQ(simulator->step(finder.find(model, simulator->state()), JointCommand{}, pushes), StepStatus::kOk)
          << simulator->fault_text();
    }
  }
};

TEST(PairContact, RefusesWhatItCannotDo) {
  Block rubber, explicit_step;
  rubber.scenario.foot_bush["body"].kz = 1e5;  // no stiffness about roll and pitch
  EXPECT_THROW(rubber.make(), InputError);
  explicit_step.scenario.integrator = "rk4";
  EXPECT_THROW(explicit_step.make(), InputError);
}

TEST(PairContact, OfAFootHasTheStiffnessOfItsRubber) {
  Block block;
  FootBushSpec& bush = block.scenario.foot_bush["body"];
  bush.kz = 4e5;
  bush.k_roll = 800;
  bush.k_pitch = 900;
  bush.c_roll = bush.c_pitch = 10;
  Simulator simulator = block.make();
  ExternalWrench push;
  push.F_W = make6(0.8, 0.9, 0, 0, 0, 0);
  block.run(&simulator, 8000, {push});
  const Matrix3d R = simulator.state().R_WB.toRotationMatrix();
  // About the rig's centre: a milliradian about each axis, to its square.
  EXPECT_NEAR(R(2, 1), 1e-3, 5e-6);
  EXPECT_NEAR(-R(2, 0), 1e-3, 5e-6);
  EXPECT_NEAR(block.half.z() - simulator.state().p_WB.z(), block.mass * 9.81 / 4e5, 1e-7);
}

TEST(PairContact, CarriesTheWeightAndSinksInByItOverTheStiffness) {
  Block block;
  Simulator simulator = block.make();
  block.run(&simulator, 4000);
  EXPECT_NEAR(block.half.z() - simulator.state().p_WB.z(), block.mass * 9.81 / 1e6, 1e-9);
  EXPECT_NEAR(simulator.contact_forces().at(0).total[5], block.mass * 9.81, 1e-4);
}

TEST(PairContact, TiltsByTheMomentOverTheRotationalStiffness) {
  Block block;
  block.scenario.contact.length_scale = 0.05;  // 2500 N m/rad
  Simulator simulator = block.make();
  ExternalWrench push;
  push.F_W = make6(0, 3.0, 0, 0, 0, 0);
  block.run(&simulator, 8000, {push});
  const Vector3d x = simulator.state().R_WB * Vector3d::UnitX();
  // The rig's centre Q is the block's own, so the weight has no moment about it. What is left of 8 s is rounding.
  EXPECT_NEAR(-std::asin(x.z()), 3.0 / (1e6 * 0.05 * 0.05), 2e-9);
}

TEST(PairContact, CreepsDownASlopeAtTheWeightOverTheDampingAndSlidesAboveTheFrictionAngle) {
  Block block;
  block.slope = 0.1;
  Simulator simulator = block.make();
  block.run(&simulator, 1000);
  // No spring holds along the floor: what equation 5 alone leaves.
  EXPECT_NEAR(simulator.state().V_WB.tail<3>().norm() / (block.mass * 9.81 * std::sin(0.1) / 2e4), 1.0, 1e-3);
  block.slope = std::atan(0.8) + 0.1;
  block.scenario.contact.stiffness = 1e7;
  Simulator steep = block.make();
  block.run(&steep, 300);
  const double v0 = steep.state().V_WB.tail<3>().norm();
  block.run(&steep, 300);
  // Clipped: friction 0.8 of the norm of the normal wrench, whose moment holds the block upright on its sole.
  const double gained = (steep.state().V_WB.tail<3>().norm() - v0) / 0.3;
  EXPECT_GT(gained, 0.5);
  EXPECT_LT(gained, solutions::calc_slide_acceleration(9.81, block.slope, 0.8));
}

TEST(PairContact, LosesOnTheWayInWhatEquationThreeTakes) {
  for (double n : {1.0, 2.0}) {
    Scenario scenario = rigs::make_scenario();
    scenario.contact.model = "wrench";
    scenario.contact.alpha = n == 1.0 ? 0.8 : 100.0;
    scenario.contact.exponent = n;
    scenario.contact.stiffness = 1e5;
    scenario.time_step = 1e-6;
    scenario.gravity_W.setZero();
    rigs::CornerFinder finder;
    finder.corners.push_back({0, Vector3d::Zero()});
    Simulator simulator(rigs::make_body(rigs::make_box_inertia(1.0, {0.1, 0.1, 0.1})), scenario);
    State state = simulator.state();
    state.V_WB[5] = -0.25;
    ASSERT_TRUE(simulator.reset(state));
    const Model model(simulator.tree());
    double deepest = 0.0;
    for (int i = 0; i < 100000 && (simulator.state().p_WB.z() <= 0.0 || simulator.state().V_WB[5] <= 0.0); ++i) {
      deepest = std::max(deepest, -simulator.state().p_WB.z());
      ASSERT_EQ(simulator.step(finder.find(model, simulator.state()), JointCommand{}), StepStatus::kOk);
    }
    // By hand: m x'' = -K x - lambda x^n x' on the way in, a linear spring alone on the way out.
    double x = 0.0, v = 0.25, lambda = 1.5 * scenario.contact.alpha * 1e5;
    for (const double h = 1e-7; v > 0.0; x += h * v) v -= h * (1e5 * x + lambda * std::pow(x, n) * v);
    EXPECT_NEAR(deepest, x, 1e-3 * x) << n;
    EXPECT_NEAR(simulator.state().V_WB[5], std::sqrt(1e5) * x, 2e-3 * 0.25) << n;  // 1 us steps: 1e-3 of the speed
  }
}

}  // namespace
}  // namespace hrp
