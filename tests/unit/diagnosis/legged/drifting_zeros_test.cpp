// SPDX-License-Identifier: BSD-3-Clause
// Zeros of foot force sensors that go on from recording to recording.
#include <gtest/gtest.h>

#include "diagnosis/floating/checks/drifting_zeros.h"
#include "tests/unit/diagnosis/legged/biped.h"

namespace hrp::diagnosis::floating {
namespace {

// Readings of a column by `end` [N] larger at the end of the last recording, in proportion to the time that was
// recorded.
void drift_column(const std::string& column, double end, Experiment* e) {
  const auto count = static_cast<double>(e->recordings.size());
  double done = 0;
  for (Recording& r : e->recordings) {
    for (size_t k = 0; k < r.size(); ++k)
      r.other.at(column)[k] += end * (done + (r.time[k] - r.time.front()) / r.duration()) / count;
    done += 1;
  }
}

TEST(LeggedLeans, AZeroThatDriftsFromRecordingToRecordingIsSaidAndTakenOut) {
  Experiment e = make_biped({}, kLeans);
  drift_column("/wrench/l/force/z", 12, &e);
  const ZeroDrift drift = find_zero_drift(e);
  ASSERT_TRUE(drift.found());
  const Finding& f = drift.findings[0];
  EXPECT_EQ(f.effect, "sensor_bias");
  EXPECT_EQ(f.grade, Grade::kAmbiguous) << "feet that stay do not tell whose zero it is";
  EXPECT_NE(f.statement.find("its zero drifts"), std::string::npos) << f.statement;
  EXPECT_NE(f.statement.find("/wrench/"), std::string::npos);
  EXPECT_FALSE(find_zero_drift(take_out(drift, e)).found());
}

Experiment make_one_lean(const Hidden& hidden, double creep, double drift) {
  Recorded leans = kLeans;
  leans.creep = creep;
  Experiment e = make_biped(hidden, leans);
  e.recordings.resize(1);
  drift_column("/wrench/l/force/z", drift, &e);
  return e;
}

TEST(LeggedLeans, AZeroThatDriftsWhileOneLongRecordingLastsIsSaidAndTakenOut) {
  const Experiment e = make_one_lean({}, 0, 12);
  const ZeroDrift drift = find_zero_drift(e);
  ASSERT_TRUE(drift.found());
  EXPECT_NE(drift.findings[0].statement.find("in the order of the stretches"), std::string::npos)
      << drift.findings[0].statement;
  EXPECT_FALSE(find_zero_drift(take_out(drift, e)).found());
}

// What the model leaves out of a lean goes on with it.
TEST(LeggedLeans, ARobotThatLeansFurtherWhileARecordingLastsIsNoDrift) {
  Hidden hidden;
  hidden.load = 2.5;
  hidden.place = {0.05, 0, 0.2};
  hidden.tether = 200;
  EXPECT_FALSE(find_zero_drift(make_one_lean(hidden, 0.1, 0)).found());
}

// Loads, scales and masses are the same in each recording.
TEST(LeggedLeans, WhatStaysTheSameInEachRecordingIsNoDrift) {
  EXPECT_FALSE(find_zero_drift(make_biped({}, kLeans)).found());
  Hidden hidden;
  hidden.load = 2.5;
  hidden.place = {0.05, 0, 0.2};
  hidden.force_scale = 1.06;
  hidden.zero_y = 2;
  EXPECT_FALSE(find_zero_drift(make_biped(hidden, kLeans)).found());
  EXPECT_FALSE(find_zero_drift(make_biped(hidden, {.effort = false})).found()) << "a walk";
}

}  // namespace
}  // namespace hrp::diagnosis::floating
