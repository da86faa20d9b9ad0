// SPDX-License-Identifier: BSD-3-Clause
// Force sensors that are turned against the model, and clocks that are off: found and taken back before anything else.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "common/spatial/turn.h"
#include "diagnosis/conventions/log_conventions.h"
#include "diagnosis/floating/conventions/body_units.h"
#include "diagnosis/floating/conventions/frame_search.h"
#include "diagnosis/floating/conventions/sensor_frames.h"
#include "diagnosis/floating/diagnose.h"
#include "diagnosis/floating/log/whole_readings.h"
#include "servers/model_parser/robot_loader.h"
#include "tests/unit/diagnosis/legged/biped.h"

namespace hrp::diagnosis::floating {
namespace {

class SensorIsTurned : public testing::TestWithParam<std::pair<Vector3d, bool>> {};

// A quarter or half turn is found before anything else, and nothing else is named for it.
TEST_P(SensorIsTurned, OntoOtherAxesAndTakenBack) {
  Hidden hidden;
  hidden.turn = GetParam().first;
  Recorded recorded = kLeans;
  recorded.imu = GetParam().second;
  const Experiment e = make_biped(hidden, recorded);
  const std::vector<SensorFrame> frames = find_sensor_frames(e);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].sensor, "/wrench/l");
  EXPECT_TRUE(frames[0].R.isApprox(make_turn(hidden.turn).toRotationMatrix(), 1e-6));
  EXPECT_EQ(frames[0].late, 0.0);
  EXPECT_TRUE(find_sensor_frames(convert_sensor_frames(e, frames)).empty());
}

INSTANTIATE_TEST_SUITE_P(Quarters, SensorIsTurned,
                         testing::Values(std::pair(Vector3d(0, 0, M_PI / 2), false),
                                         std::pair(Vector3d(0, 0, M_PI), true),
                                         std::pair(Vector3d(M_PI, 0, 0), false)));

TEST(SensorFrames, NoneIsTurnedWhereNothingIsHidden) {
  for (const bool leans : {false, true}) {
    Recorded recorded;
    recorded.leans = leans;
    EXPECT_TRUE(find_sensor_frames(make_biped({}, recorded)).empty());
  }
}

// Roll and yaw are one angle where pitch is a right angle: both were reported as none.
TEST(SensorFrames, AQuarterTurnAboutTwoAxesIsReportedAsAnglesThatMakeIt) {
  LogConventions logged;
  logged.frames.push_back({"/wrench/l", make_rotation_from_rpy({M_PI / 2, M_PI / 2, 0}), 0.0, 0.01, ""});
  Reports reports;
  reports.report["findings"] = nlohmann::ordered_json::array();
  add_conventions(make_biped({}), logged, &reports);
  const auto rpy = reports.report["findings"][0]["parameters"]["rpy"]["value"].get<std::vector<double>>();
  EXPECT_TRUE(make_rotation_from_rpy({rpy[0], rpy[1], rpy[2]}).isApprox(logged.frames[0].R, 1e-4));
}

// The model has the sensors above the feet; the log has what the ground does to whole feet. Their weight was named as a
// zero of the sensors.
TEST(WholeReadings, AreToldByFeetInTheAir) {
  Recorded recorded;
  recorded.lifts = true;
  EXPECT_TRUE(find_whole_readings(make_biped({}, recorded)).empty()) << "they hang on their sensors";
  recorded.whole_feet = true;
  const Experiment e = make_biped({}, recorded);
  const std::vector<WholeReading> found = find_whole_readings(e);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].sensor, "l");
  EXPECT_DOUBLE_EQ(found[0].mass, 0.5);
  EXPECT_FALSE(diagnose_legged(e, nullptr).evidence.findings.empty()) << "0.5 kg on each foot";
  EXPECT_TRUE(diagnose_legged(convert_whole_readings(e, found), nullptr).evidence.findings.empty());
  EXPECT_TRUE(find_whole_readings(make_biped({})).empty());
}

// A log without negative forces reads 0 for every foot in the air, as whole feet would. The sum of the feet's forces
// tells.
TEST(WholeReadings, AreNotTakenFromALogThatKeepsNoNegativeForces) {
  Recorded recorded;
  recorded.lifts = true;
  for (const bool whole : {false, true}) {
    recorded.whole_feet = whole;
    Experiment e = make_biped({}, recorded);
    for (Recording& r : e.recordings) {
      for (const char* column : {"/wrench/l/force/z", "/wrench/r/force/z"}) {
        for (double& force : r.other.at(column)) force = std::max(0.0, force);
      }
    }
    const std::vector<WholeReading> found = find_whole_readings(e);
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].cut, !whole);
  }
}

// Noise of 8 N beside a foot of 4.9 N: some readings in the air are above 0, so that smoothed ones differ.
TEST(WholeReadings, WhatALogCutsOffIsWhatTheFootMakesItsSensorRead) {
  Recorded recorded;
  recorded.lifts = true;
  Experiment e = make_biped({}, recorded);
  std::mt19937 random(53);
  std::normal_distribution<double> noise(0, 8);
  std::vector<double> logged;
  for (Recording& r : e.recordings) {
    for (const char* column : {"/wrench/l/force/z", "/wrench/r/force/z"}) {
      for (double& force : r.other.at(column)) {
        logged.push_back(force);
        force = std::max(0.0, force + noise(random));
      }
    }
  }
  const std::vector<WholeReading> found = find_whole_readings(e);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_TRUE(found[0].cut && found[1].cut);
  const Experiment converted = convert_whole_readings(e, found);
  double error = 0, count = 0;
  size_t at = 0;
  for (const Recording& r : converted.recordings) {
    for (const char* column : {"/wrench/l/force/z", "/wrench/r/force/z"}) {
      for (double force : r.other.at(column)) {
        if (force < 0) {
          error += force - logged[at];
          count += 1;
        }
        ++at;
      }
    }
  }
  ASSERT_GT(count, 0);
  EXPECT_NEAR(error / count, 0, 0.25) << "5 % of the foot's weight: it is taken as a point at its sensor";
}

// Its z axis points down by the model, as those of the iCub's feet do: a foot that is pressed reads negative there.
TEST(SensorFrames, ASensorThatHangsUpsideDownInTheModelIsNotTurned) {
  Experiment e = make_biped({}, kLeans);
  hang_upside_down(&e);
  EXPECT_TRUE(find_body_units(e).empty());
  EXPECT_TRUE(find_sensor_frames(e).empty());
  EXPECT_TRUE(diagnose_legged(e, nullptr).evidence.findings.empty());
}

// Forces by a computer whose clock is 0.2 s behind that of the encoders.
TEST(SensorFrames, AClockThatIsFarOffIsMoved) {
  Experiment e = make_biped({}, kLeans);
  const Experiment true_time = e;
  for (Recording& r : e.recordings) {
    for (auto& [name, column] : r.other) std::rotate(column.begin(), column.end() - 50, column.end());
  }
  const std::vector<SensorFrame> frames = find_sensor_frames(e);
  ASSERT_EQ(frames.size(), 2u);
  for (const SensorFrame& f : frames)
    EXPECT_NEAR(f.late, 0.2, 0.015);  // one and a half steps of the clock that is looked for
}

// Beyond the half second that is looked at first: 1.2 s behind, 2 s ahead.
TEST(SensorFrames, AClockThatIsSecondsOffIsMoved) {
  for (const long samples : {300L, -500L}) {
    Experiment e = make_biped({}, kLeans);
    for (Recording& r : e.recordings) {
      for (auto& [name, column] : r.other)
        std::rotate(column.begin(), samples > 0 ? column.end() - samples : column.begin() - samples, column.end());
    }
    const std::vector<SensorFrame> frames = find_sensor_frames(e);
    ASSERT_EQ(frames.size(), 2u);
    for (const SensorFrame& f : frames) EXPECT_NEAR(f.late, 0.004 * static_cast<double>(samples), 0.015);
  }
}

// A sensor against encoders, both every 20 ms for 5 s; what a clock leaves at moments, in units of what is known.
struct Pair {
  std::vector<double> encoders, sensor;
  double find_late() const {
    const auto n = static_cast<long>(encoders.size());
    const auto list = [&](Purpose side) {
      std::vector<long> out;
      for (long k = side == Purpose::kForFarAhead ? 150 : 0; k < n - (side == Purpose::kForFarBehind ? 150 : 0); ++k)
        out.push_back(k);
      return out;
    };
    const auto measure = [&](const std::vector<long>& moments) -> Left {
      return [this, &moments, n](const Matrix3d&, const Clock& clock) {
        double sum = 0;
        for (long k : moments) {
          const long at = clock.held >= 0 ? std::lround(clock.held * static_cast<double>(n - 1))
                                          : std::clamp(k + std::lround(clock.late / 0.02), 0L, n - 1);
          sum += std::pow(10 * (sensor[static_cast<size_t>(at)] - encoders[static_cast<size_t>(k)]), 2);
        }
        return sum / static_cast<double>(moments.size()) + 1;
      };
    };
    return find_far_clock(list, measure, {}).late;
  }
};

// A robot that stands for 2.2 s and then moves 20 times as briskly as its legs tell, as one that falls: readings from
// before look better, at each moment, than its own.
TEST(SensorFrames, RestBeforeABriskMotionIsNoClock) {
  std::mt19937 random(67);
  std::normal_distribution<double> normal;
  Pair late, falls;
  for (int k = 0; k < 250; ++k) {
    late.encoders.push_back(normal(random));
    falls.encoders.push_back(0.1 * normal(random));
  }
  for (int k = 0; k < 250; ++k) {
    late.sensor.push_back(k < 60 ? normal(random) : late.encoders[static_cast<size_t>(k - 60)]);
    falls.sensor.push_back(k >= 8 && k < 110 ? 0.005 * normal(random) : 2 * normal(random));
  }
  EXPECT_NEAR(late.find_late(), 1.2, 0.01);
  EXPECT_EQ(falls.find_late(), 0.0);
}

// No shift puts what a drifting clock stamped where it belongs: its rate is an effect of its own.
TEST(SensorFrames, AClockThatRunsFastIsNotMoved) {
  Experiment e = make_biped({}, kLeans);
  for (Recording& r : e.recordings) {
    for (auto& [name, column] : r.other) {
      const std::vector<double> was = column;
      for (size_t k = 0; k < was.size(); ++k) column[k] = was[std::min(was.size() - 1, k + k / 50)];  // 2 %
    }
  }
  for (const SensorFrame& f : find_sensor_frames(e)) EXPECT_EQ(f.late, 0.0) << f.sensor;
}

}  // namespace
}  // namespace hrp::diagnosis::floating
