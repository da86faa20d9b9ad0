// SPDX-License-Identifier: BSD-3-Clause
// The clock of the feet's forces against that of the body's motion.
#include "diagnosis/floating/conventions/force_clock.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/floating/diagnose.h"
#include "tests/unit/diagnosis/legged/biped.h"
#include "tests/unit/diagnosis/legged/late_columns.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kSample = 0.01;  // [s]

// 10 s of a body that shakes at 2 to 5 Hz. What its accelerometer feels beside it shakes as much. `moves` [N]: 0 for a
// recording of noise.
PressedStretch make_stretch(int recording, double late, double moves) {
  std::mt19937 random(static_cast<unsigned>(71 + recording));
  std::normal_distribution<double> normal;
  PressedStretch out{recording, kSample, {{}}, {}};
  const auto shake = [&](double t) {
    return moves * (std::sin(13 * t + recording) + std::sin(21 * t) + std::sin(31 * t + 1));
  };
  for (double t = 0; t < 10; t += kSample) {
    const double elsewhere = moves * (std::sin(17 * t) + std::sin(26 * t + 2));
    out.force[0].push_back(300 + 20 * std::sin(t) + 0.5 * shake(t - late) + normal(random));
    out.needed.push_back(310 + shake(t) + elsewhere + normal(random));
  }
  return out;
}

TEST(ForceClock, ARecordingWithoutMotionDoesNotHideThatForcesAreLate) {
  const ForceClock clock =
      find_force_clock({make_stretch(0, 0.03, 40), make_stretch(1, 0.03, 20), make_stretch(2, 0.03, 0)}, kSample);
  EXPECT_TRUE(clock.found);
  EXPECT_NEAR(clock.late, 0.03, std::max(0.002, 3 * clock.std));
  EXPECT_LT(clock.std, 0.006);
}

TEST(ForceClock, ForcesInTimeAndRecordingsThatDisagreeAreNotLate) {
  EXPECT_FALSE(find_force_clock({make_stretch(0, 0, 40), make_stretch(1, 0, 20)}, kSample).found);
  EXPECT_FALSE(find_force_clock({make_stretch(0, 0.03, 40), make_stretch(1, 0.001, 40)}, kSample).found);
}

// Feet that take turns: each carries the body for a second.
PressedStretch make_steps(int recording, const std::vector<double>& late) {
  std::mt19937 random(static_cast<unsigned>(91 + recording));
  std::normal_distribution<double> normal;
  const auto shake = [&](double t) {
    return 40 * (std::sin(13 * t + recording) + std::sin(21 * t) + std::sin(31 * t + 1));
  };
  PressedStretch out{recording, kSample, std::vector<std::vector<double>>(late.size()), {}};
  for (double t = 0; t < 30; t += kSample) {
    for (size_t f = 0; f < late.size(); ++f) {
      const double at = t - late[f], share = 0.5 + 0.5 * std::sin(M_PI * at + 2 * M_PI * static_cast<double>(f) /
                                                                                  static_cast<double>(late.size()));
      out.force[f].push_back(share * (300 + shake(at)) + normal(random));
    }
    out.needed.push_back(300 + shake(t) + normal(random));
  }
  return out;
}

TEST(ForceClock, OneLateFootIsToldFromAllFeetThatAreLate) {
  const ForceClock one = find_force_clock({make_steps(0, {0, 0.05}), make_steps(1, {0, 0.05})}, kSample);
  EXPECT_TRUE(one.found);
  EXPECT_EQ(one.foot, size_t{1});
  EXPECT_NEAR(one.late, 0.05, 0.005);
  const ForceClock all = find_force_clock({make_steps(0, {0.05, 0.05}), make_steps(1, {0.05, 0.05})}, kSample);
  EXPECT_TRUE(all.found);
  EXPECT_EQ(all.foot, std::nullopt);
  EXPECT_TRUE(all.rivals.empty());
}

// Delays [s] that the report finds, by sensor, of vertical forces alone.
std::vector<std::pair<std::string, double>> find_delays(const std::string& columns, long samples) {
  Recorded recorded{.lifts = true};
  recorded.six_axes = false;
  Experiment e = make_biped({}, recorded);
  delay_columns(columns, samples, &e);
  std::vector<std::pair<std::string, double>> out;
  const Evidence evidence = diagnose_legged(e, nullptr).evidence;
  for (const SignalFit& s : evidence.fit.signals) EXPECT_GT(s.spread, 0) << s.signal;  // shares are of it
  for (const Finding& f : evidence.findings) {
    if (f.effect == "sensor_delay")
      out.emplace_back(f.where.begin()->get<std::string>(), f.parameters.at(0).value.at(0));
  }
  return out;
}

TEST(ForceClock, ForcesOfBothFeetOrTheImuAreLate) {
  const auto feet = find_delays("/wrench/", 10);
  ASSERT_EQ(feet.size(), 1u);
  EXPECT_EQ(feet[0].first, "/wrench");
  EXPECT_NEAR(feet[0].second, 0.04, 0.004);
  const auto imu = find_delays("/imu/waist/linear_acceleration", 10);
  ASSERT_EQ(imu.size(), 1u);
  EXPECT_EQ(imu[0].first.rfind("/imu/waist", 0), 0u);
  EXPECT_NEAR(imu[0].second, 0.04, 0.004);
}

}  // namespace
}  // namespace hrp::diagnosis::floating
