// SPDX-License-Identifier: BSD-3-Clause
// A foot's vertical force that is late against the other foot's.
#include "diagnosis/floating/checks/late_feet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "diagnosis/floating/diagnose.h"
#include "tests/unit/diagnosis/legged/biped.h"
#include "tests/unit/diagnosis/legged/late_columns.h"
#include "tests/unit/diagnosis/legged/rows.h"

namespace hrp::diagnosis::floating {
namespace {

// Feet that bear 300 N in turn, with steps of 1.6 s. Each sensor is late [s], the left one also scaled.
LateFoot find_late(double left, double right, double scale) {
  Recorded recorded;
  recorded.six_axes = false;
  const LeggedLog log = make_legged_log(make_biped({}, recorded), Half::kEven);
  const ColumnLayout layout(log);
  const int l = layout.sensor(0, kWrenchDelayColumn), r = layout.sensor(1, kWrenchDelayColumn);
  RowHalves rows(layout.count(), 900, {{kWeight, {l, r}}});
  std::mt19937 random(53);
  std::normal_distribution<double> normal;
  for (int i = 0; i < rows.cells(); ++i) {
    const double phase = 2 * M_PI * 0.04 * i / 1.6, slope = 300 * 0.5 * std::cos(phase) * 2 * M_PI / 1.6;
    const double bears = 300 * (0.5 + 0.5 * std::sin(phase)), common = 30 * normal(random), error = 3 * normal(random);
    const double of_left = slope + common, of_right = -slope + common;
    rows.add_cell(i, get_mixed_roughness(i), [&](RowTable* half, double) {
      half->begin_row(0, 10 - left * of_left - right * of_right + (scale - 1) * bears + error, 300);
      half->add(0, l, -of_left);
      half->add(0, r, -of_right);
    });
  }
  return find_late_foot(log, rows.merge(), layout);
}

TEST(LateFeet, OneIsLateAgainstTheOther) {
  const LateFoot late = find_late(0.01, 0.04, 1);
  EXPECT_EQ(late.sensor, 1);
  EXPECT_NEAR(late.delay, 0.03, 4 * late.std);
  EXPECT_LT(late.std, 0.003);
}

TEST(LateFeet, WhatBothShareAndAScaleAreNoDelayOfOne) {
  EXPECT_EQ(find_late(0.04, 0.04, 1).sensor, -1);
  EXPECT_EQ(find_late(0, 0, 1.1).sensor, -1);
}

// A slope of the force holds for small delays alone: 0.6 s on a real walk came out as 0.2 s, `supported`.
TEST(LateFeet, OneThatIsHalfASecondLateIsToldByMovingIt) {
  Recorded recorded{.lifts = true};
  recorded.six_axes = false;
  Experiment e = make_biped({}, recorded);
  delay_columns("/wrench/l/", 125, &e);
  const Evidence evidence = diagnose_legged(e, nullptr).evidence;
  const auto late = std::find_if(evidence.findings.begin(), evidence.findings.end(),
                                 [](const Finding& f) { return f.effect == "sensor_delay"; });
  ASSERT_NE(late, evidence.findings.end());
  EXPECT_EQ(late->where.begin()->get<std::string>(), "/wrench/l");
  EXPECT_NEAR(late->parameters.at(0).value.at(0), 0.5, 0.02);
}

}  // namespace
}  // namespace hrp::diagnosis::floating
