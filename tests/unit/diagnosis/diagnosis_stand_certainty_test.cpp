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

}  // namespace
}  // namespace hrp::diagnosis::upright
