// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/diagnostics.h"
#include "diagnosis/data/csv.h"
#include "diagnosis/data/recording.h"
#include "diagnosis/data/smooth.h"

namespace hrp::diagnosis {
namespace {

std::string write_file(const std::string& name, const std::string& text) {
  const std::string path = (std::filesystem::temp_directory_path() / ("hrp_diagnosis_" + name)).string();
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

std::string read_error(const std::string& path) {
  std::vector<std::string> warnings;
  try {
    read_csv(path, &warnings);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Csv, NamesLineAndColumnOfACellThatIsNoNumber) {
  const std::string path = write_file("bad.csv", "time,a\n0,1\n0.1,x2\n0.2,3\n");
  EXPECT_THAT(read_error(path), testing::HasSubstr("bad.csv:3:2:"));
}

TEST(Csv, RefusesRowsWithTooManyCellsAndRepeatedColumns) {
  EXPECT_THAT(read_error(write_file("wide.csv", "time,a\n0,1,2\n")), testing::HasSubstr("wide.csv:2:"));
  EXPECT_THAT(read_error(write_file("twice.csv", "time,a,a\n0,1,2\n1,1,2\n")), testing::HasSubstr("twice"));
}

TEST(Csv, TakesMissingCellsAsMissingAndDropsACutLastLine) {
  std::vector<std::string> warnings;
  const Table table = read_csv(write_file("gaps.csv", "time,a,b\r\n0,1,\r\n0.1,nan,2\r\n0.2,3"), &warnings);
  ASSERT_EQ(table.rows(), 2u);
  EXPECT_TRUE(std::isnan(table.columns[2][0]));
  EXPECT_TRUE(std::isnan(table.columns[1][1]));
  EXPECT_EQ(warnings.size(), 1u);
}

TEST(Noise, IsFoundUnderASmoothMotion) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0.0, 0.003);
  std::vector<double> signal;
  for (int k = 0; k < 4000; ++k) signal.push_back(std::sin(0.01 * k) + normal(random));
  // 4000 samples of third differences know a standard deviation to about 4 %.
  EXPECT_NEAR(estimate_noise(signal), 0.003, 0.003 * 0.12);
}

TEST(Smoothing, GivesDerivativesOfACubicExactlyOnIrregularStamps) {
  std::vector<double> time, values, value, rate, second;
  for (int k = 0; k < 60; ++k) {
    time.push_back(0.01 * k + 0.003 * std::sin(1.7 * k));
    const double t = time.back();
    values.push_back(1.0 + 2.0 * t - 3.0 * t * t + 4.0 * t * t * t);
  }
  smooth_series(time, values, 6, &value, &rate, &second);
  for (size_t k = 0; k < time.size(); ++k) {
    const double t = time[k];
    EXPECT_NEAR(rate[k], 2.0 - 6.0 * t + 12.0 * t * t, 1e-6);   // 1e-12 of ridge in the local fits, scaled
    EXPECT_NEAR(second[k], -6.0 + 24.0 * t, 1e-4);
  }
}

}  // namespace
}  // namespace hrp::diagnosis
