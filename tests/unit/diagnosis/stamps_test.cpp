// SPDX-License-Identifier: BSD-3-Clause
// Time stamps of single rows that err.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/conventions/stamps.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

constexpr double kError = 5e-4;  // [s] standard deviation: a tenth of the time between rows

// [s] Errors of the stamps, within three standard deviations.
std::vector<double> draw_errors(size_t rows) {
  TestNoise noise;
  std::vector<double> errors;
  for (size_t k = 0; k < rows; ++k) errors.push_back(kError * std::max(-3.0, std::min(3.0, noise.draw())));
  return errors;
}

double find_rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

// All readings of a row and its commands have one stamp.
TEST(Stamps, ErrorsOfSingleRowsAreToldByAllCommands) {
  Experiment e = simulate_arm("late_stamps", make_arm_drives());
  const std::vector<double> right = e.recordings[0].time, errors = draw_errors(right.size());
  for (size_t k = 0; k < right.size(); ++k) e.recordings[0].time[k] += errors[k];
  const size_t before = e.warnings.size();
  const Experiment corrected = correct_stamps(e);
  std::vector<double> left;
  for (size_t k = 0; k < right.size(); ++k) left.push_back(corrected.recordings[0].time[k] - right[k]);
  EXPECT_LT(find_rms(left), 0.2 * find_rms(errors));
  ASSERT_EQ(corrected.warnings.size(), before + 1);
  EXPECT_THAT(corrected.warnings.back(), testing::HasSubstr("r0.csv"));
}

TEST(Stamps, RightStampsStayEvenWhereRowsAreUneven) {
  Experiment e = simulate_arm("right_stamps", make_arm_drives());
  EXPECT_TRUE(find_stamp_errors(e.recordings[0]).empty());
  Recording& r = e.recordings[0];
  const std::vector<double> early = draw_errors(r.size());
  for (size_t k = 0; k < r.size(); ++k) {  // the row was taken at another time, and its stamp says so
    r.time[k] += early[k];
    for (JointColumns& joint : r.joints) {
      joint.command[k] += early[k] * joint.command_rate[k];
      joint.signal[0][k] += early[k] * joint.signal[1][k];
    }
  }
  EXPECT_TRUE(find_stamp_errors(r).empty());
}

// A controller may send its commands unevenly while the log's clock is right.
TEST(Stamps, CommandsThatMeasuredPositionsContradictCorrectNothing) {
  Experiment e = simulate_arm("uneven_commands", make_arm_drives());
  Recording& r = e.recordings[0];
  const std::vector<double> early = draw_errors(r.size());
  for (JointColumns& joint : r.joints) {
    for (size_t k = 0; k < r.size(); ++k) joint.command[k] += early[k] * joint.command_rate[k];
  }
  EXPECT_TRUE(find_stamp_errors(r).empty());
}

}  // namespace
}  // namespace hrp::diagnosis
