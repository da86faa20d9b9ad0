// SPDX-License-Identifier: BSD-3-Clause
// Least squares from sums of products.
#include <gtest/gtest.h>

#include <cmath>

#include "diagnosis/estimate/gram.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

// Torque [N m] of a load of 2 kg at 0.12 m beside dry friction, over a stretch in which the arm hardly turns: the
// columns of mass and moment are nearly the same, and only the noise tells them apart.
Gram make_stretch_of_a_load(TestNoise* noise) {
  Gram gram(3);
  for (int k = 0; k < 200; ++k) {
    const double q = 0.2 + 0.02 * std::sin(0.1 * k), direction = std::cos(0.1 * k) > 0.0 ? 1.0 : -1.0;
    const Eigen::Vector3d x(9.81 * 0.3 * std::cos(q), 9.81 * std::cos(q + 1e-4 * std::sin(0.3 * k)), direction);
    gram.add_row(x, 2.0 * x[0] + 0.24 * x[1] + 0.5 * direction + 0.05 * noise->draw());
  }
  return gram;
}

TEST(Gram, NearlyEqualColumnsHaveLargeDeviations) {
  TestNoise noise;
  const Gram gram = make_stretch_of_a_load(&noise);
  const Eigen::MatrixXd inverse = calc_inverse(gram, {0, 2});
  const double alone = 1.0 / gram.get(0, 0);
  EXPECT_GT(inverse(0, 0), alone) << "beside another column less is known than alone";
  const double product = inverse(0, 0) * gram.get(0, 0) + inverse(0, 1) * gram.get(0, 2);
  EXPECT_NEAR(product, 1.0, 1e-6);  // a ridge of 1e-9 of the columns, which differ by far more
  EXPECT_GT(calc_inverse(gram, {0, 1})(0, 0), 1e3 * alone);
}

TEST(Gram, AStretchThatCannotTellAMassFromItsPlaceStillTellsTheLoad) {
  TestNoise noise;
  const Eigen::Vector2d load(2.0, 0.24);
  int negative = 0;
  for (int stretch = 0; stretch < 20; ++stretch) {
    const Gram gram = make_stretch_of_a_load(&noise);
    negative += solve(gram, {0, 1, 2})[0] < 0.0 ? 1 : 0;
    // 1 %: noise of 0.05 N m in 200 samples of 8 N m.
    EXPECT_NEAR(solve_along(gram, {0, 1, 2}, 0, load), 1.0, 0.01);
  }
  EXPECT_GT(negative, 3) << "the masses alone should scatter over zero, or this test shows nothing";
}

TEST(Gram, AlongASingleColumnTheAmplitudeIsThatOfTheFreeFit) {
  TestNoise noise;
  const Gram gram = make_stretch_of_a_load(&noise);
  const double free = solve(gram, {0, 2})[1];
  EXPECT_NEAR(solve_along(gram, {0, 2}, 1, Eigen::VectorXd::Constant(1, 0.5)), free / 0.5, 1e-9 * std::abs(free));
}

TEST(Gram, RowsAddedTogetherGiveTheSumsOfRowsOneByOne) {
  TestNoise noise;
  Eigen::MatrixXd X(4, 50);
  Eigen::VectorXd y(50);
  Gram single(4), together(4);
  for (long k = 0; k < y.size(); ++k) {
    for (long i = 0; i < X.rows(); ++i) X(i, k) = noise.draw();
    y[k] = noise.draw();
    single.add_row(X.col(k), y[k]);
  }
  together.add_columns(X, y);
  // sums in another order: rounding of 50 products
  const double rounding = 1e-12 * single.c;
  for (long i = 0; i < 4; ++i) {
    for (long j = 0; j < 4; ++j) EXPECT_NEAR(together.get(i, j), single.get(i, j), rounding);
    EXPECT_NEAR(together.b[i], single.b[i], rounding);
  }
  EXPECT_NEAR(together.c, single.c, rounding);
  EXPECT_EQ(together.n, single.n);
}

// The choice of a joint's terms leaves subsets out by this bound, without looking at the folds.
TEST(Gram, AFitToAllFoldsLeavesLessThanFoldsThatArePredictedFromTheOthers) {
  TestNoise noise;
  std::vector<Gram> folds;
  for (int f = 0; f < 8; ++f) folds.push_back(make_stretch_of_a_load(&noise));
  const Gram total = sum(folds, 3);
  for (const Columns& columns : {Columns{0}, Columns{1, 2}, Columns{0, 1, 2}})
    EXPECT_LT(calc_rest(total, columns, solve(total, columns)) / total.n, cross_validate(folds, total, columns));
}

}  // namespace
}  // namespace hrp::diagnosis
