// SPDX-License-Identifier: BSD-3-Clause
#include "common/multibody/sine_cosine.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace hrp {
namespace {

void expect_near_library(const std::vector<double>& angles, double tolerance) {
  std::vector<double> sine(angles.size()), cosine(angles.size());
  calc_sine_cosine(angles.data(), static_cast<int>(angles.size()), sine.data(), cosine.data());
  for (size_t i = 0; i < angles.size(); ++i) {
    EXPECT_NEAR(sine[i], std::sin(angles[i]), tolerance) << angles[i];
    EXPECT_NEAR(cosine[i], std::cos(angles[i]), tolerance) << angles[i];
  }
}

TEST(SineCosine, AgreesWithTheLibraryOverManyTurns) {
  std::vector<double> angles = {0.0, -0.0, 1e-300};
  for (int i = -20000; i <= 20000; ++i) angles.push_back(0.00137 * i);
  for (int i = -1000; i <= 1000; ++i) angles.push_back(1.5707963267948966 * i);
  expect_near_library(angles, 2.3e-16);  // one unit in the last place of numbers near 1
}

TEST(SineCosine, AgreesWithTheLibraryForHugeAngles) { expect_near_library({9.9e4, -9.9e4, 1e5, 1e9, -1e300}, 2.3e-16); }

TEST(SineCosine, PassesNanOn) {
  const double angle[2] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()};
  double sine[2], cosine[2];
  calc_sine_cosine(angle, 2, sine, cosine);
  for (double value : {sine[0], sine[1], cosine[0], cosine[1]}) EXPECT_TRUE(std::isnan(value));
}

}  // namespace
}  // namespace hrp
