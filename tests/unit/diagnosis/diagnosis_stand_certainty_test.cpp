// SPDX-License-Identifier: BSD-3-Clause
// Standing robots: what the search is sure of, and steps of its fits.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "diagnosis/upright/channels.h"
#include "diagnosis/upright/layout.h"
#include "diagnosis/upright/search.h"

namespace hrp::diagnosis::upright {
namespace {

// Tables of chi-square for 5 %, two and three degrees of freedom.
TEST(StandingCertainty, OfAVectorAsksForMoreThanOfOneNumber) {
  EXPECT_NEAR(find_length(1.95996, 1), 1.960, 1e-3);
  EXPECT_NEAR(find_length(1.95996, 2), std::sqrt(5.991), 1e-3);
  EXPECT_NEAR(find_length(1.95996, 3), std::sqrt(7.815), 1e-3);
}

// An offset forward and one upward look nearly alike: neither is sure, a tenth of their difference is.
TEST(StandingCertainty, OfAVectorDoesNotDependOnItsAxes) {
  Eigen::Matrix3d C;
  C << 1, 0.995, 0, 0.995, 1, 0, 0, 0, 1;
  const Vector3d offset(0.7, -0.7, 0.1);
  EXPECT_GT(calc_deviations(offset, C), 9) << "0.7 sqrt(2) / sqrt(0.005) = 14 along the difference, at most 0.7 alone";
  const Eigen::Matrix3d R = Eigen::AngleAxisd(0.8, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  EXPECT_NEAR(calc_deviations(R * offset, R * C * R.transpose()), calc_deviations(offset, C), 1e-9);
}

// A signal of size 1 with noise of size 1 in it, twice: 2 is what makes the residual small.
TEST(StandingFit, StepsBetweenTwoHalvesAreNotMadeSmallByNoise) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  Evaluation base(1);
  std::vector<Derivative> even{{{}}}, odd{{{}}};
  for (int k = 0; k < 20000; ++k) {
    const double signal = normal(random);
    base[0].residuals.push_back(-2 * signal);
    even[0][0].push_back(signal + normal(random)), odd[0][0].push_back(signal + normal(random));
  }
  const FitSelection selection{{0}, {1.0}};
  const SharedColumns nothing = share_columns(selection, {}, base);
  const StandHypothesis h{{StandId::kViscous, 0, {0}}};
  const ColumnSide x{nothing, even}, y{nothing, odd};
  EXPECT_NEAR(solve_with({}, selection, h, x, x)(0), 1.0, 0.05) << "half of the column's square is noise";
  EXPECT_NEAR(solve_with({}, selection, h, x, y)(0), 2.0, 0.1) << "five deviations of 2 sqrt(2 / 20000)";
}

// The damping of a small robot's sole is within its noise: what is sure of the sole is not given up for that.
TEST(StandingFit, ADampingBelowNothingDoesNotCostTheSole) {
  StandProblem p;
  p.feet.resize(1);
  StandHypothesis h{make_soft_soles(p)};
  Eigen::VectorXd step = Eigen::VectorXd::Zero(static_cast<long>(kFootParameters));
  step.head<4>() << 0.04, -0.015, 0.03, 0.01;
  add_step(step, 0, &h);
  EXPECT_TRUE(are_sensible(p, h));
  EXPECT_EQ(h[0].p[1], 0);
  EXPECT_EQ(h[0].p[3], 0.01);
}

// How high a hip's centre of mass is hardly shows in a robot that stands.
TEST(StandingEffects, ACentreOfMassIsExpectedWithinItsLink) {
  StandProblem p;
  p.tree.links.resize(1);
  p.tree.links[0].inertia.mass = 4;
  EXPECT_NEAR(find_prior(p, {StandId::kComError, 0, {0, 0, 0}}, 2), 0.2, 1e-9) << "a cube of 4 kg at 500 kg/m^3";
}

}  // namespace
}  // namespace hrp::diagnosis::upright
