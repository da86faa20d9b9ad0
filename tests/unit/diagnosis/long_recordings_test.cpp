// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

#include <gtest/gtest.h>

#include "diagnosis/data/csv_stream.h"
#include "diagnosis/data/stretches.h"
#include "diagnosis/search/fitted_part.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

// 100 s at 100 Hz; the joint moves from 40 to 60 s only.
Recording make_recording() {
  Recording r;
  r.spec.name = "long.csv";
  r.joints.resize(1);
  for (int k = 0; k < 10000; ++k) {
    const double t = 0.01 * k;
    r.time.push_back(t);
    r.joints[0].signal[0].push_back(t >= 40.0 && t < 60.0 ? std::sin(3.0 * (t - 40.0)) : 0.0);
    r.other["/imu/hand/angular_velocity/x"].push_back(t);
  }
  return r;
}

TEST(LongRecordings, AreCutToTheStretchesInWhichJointsMove) {
  const std::vector<Recording> parts = cut_to_stretches(make_recording(), 20.0);
  ASSERT_EQ(parts.size(), 1u);  // neighbours stay together
  // Pieces are 10 s long, to a sample.
  EXPECT_NEAR(parts[0].time.front(), 40.0, 0.1);
  EXPECT_NEAR(parts[0].time.back(), 60.0, 0.1);
  EXPECT_EQ(parts[0].other.at("/imu/hand/angular_velocity/x").front(), parts[0].time.front());
}

TEST(LongRecordings, OfOneLengthStayWhole) {
  const std::vector<Recording> parts = cut_to_stretches(make_recording(), 100.0);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].size(), 10000u);
  EXPECT_EQ(parts[0].spec.name, "long.csv");
}

// A robot of one joint on its feet, with a recording that is fitted and one that is held out.
Experiment make_standing(double seconds) {
  Experiment e;
  e.scenario.floating_base = true;
  LinkSpec trunk, arm;
  trunk.name = "trunk";
  arm.name = "arm";
  arm.parent = 0;
  arm.joint.name = "shoulder";
  e.robot.tree.links = {trunk, arm};
  for (const bool train : {true, false}) {
    Recording r;
    r.spec.name = r.spec.file = train ? "train.csv" : "held.csv";
    r.spec.train = train;
    r.joints.resize(1);
    for (int k = 0; k < std::lround(50.0 * seconds); ++k) {
      r.time.push_back(0.02 * k);
      r.joints[0].signal[0].push_back(std::sin(1e-4 * k * k));  // faster and faster
    }
    e.recordings.push_back(r);
  }
  return e;
}

// Every hypothesis is evaluated at every sample: ten minutes took as many minutes, and 3 GB.
TEST(LongRecordings, OfRobotsOnTheirFeetAreSearchedOnTwoMinutesAThirdOfThemHeldOut) {
  const Experiment e = make_standing(600.0);
  ASSERT_GT(calc_joint_seconds(e), calc_searched(e));
  double fitted = 0.0, held = 0.0;
  for (const Recording& r : make_screened(e, calc_searched(e)).recordings)
    (r.spec.train ? fitted : held) += r.duration();
  EXPECT_NEAR(fitted, 80.0, 0.1);  // whole pieces of 10 s, to a sample each
  EXPECT_NEAR(held, 40.0, 0.1);
  const Experiment minute = make_standing(30.0);
  EXPECT_LT(calc_joint_seconds(minute), calc_searched(minute));
}

TEST(LongRecordings, OfBodiesWithoutJointsStayWhole) {
  Experiment e = make_standing(600.0);
  e.robot.tree.links.resize(1);
  for (Recording& r : e.recordings) r.joints.clear();
  EXPECT_LE(calc_joint_seconds(e), calc_searched(e));
}

// Without the samples in which `lost` is true.
Recording lose(const Recording& r, const std::function<bool(double)>& lost) {
  Recording out;
  out.spec = r.spec;
  out.joints.resize(1);
  for (size_t k = 0; k < r.size(); ++k) {
    if (lost(r.time[k])) continue;
    out.time.push_back(r.time[k]);
    out.joints[0].signal[0].push_back(r.joints[0].signal[0][k]);
    out.other["/imu/hand/angular_velocity/x"].push_back(r.time[k]);
  }
  return out;
}

TEST(RecordingsWithGaps, FallIntoTheirPartsAndSaySo) {
  std::vector<std::string> warnings;
  const std::vector<Recording> parts =
      cut_at_gaps(lose(make_recording(), [](double t) { return t > 49.995 && t < 51.995; }), &warnings);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_DOUBLE_EQ(parts[0].time.back(), 49.99);
  EXPECT_DOUBLE_EQ(parts[1].time.front(), 52.0);
  EXPECT_EQ(parts[1].other.at("/imu/hand/angular_velocity/x").front(), 52.0);
  EXPECT_EQ(parts[1].spec.name, "long.csv (52 to 99.99 s)");
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0], "long.csv: a gap without samples from 49.99 to 52 s: nothing is carried across");
}

TEST(RecordingsWithGaps, LoseWhatIsTooShortToTellAnything) {
  std::vector<std::string> warnings;
  const auto lost = [](double t) { return (t > 9.995 && t < 11.995) || (t > 12.505 && t < 14.995); };
  ASSERT_EQ(cut_at_gaps(lose(make_recording(), lost), &warnings).size(), 2u);
  EXPECT_EQ(warnings[0],
            "long.csv: 2 gaps, the first without samples from 9.99 to 12 s: nothing is carried across; 0.5 s in parts "
            "shorter than a second are left out");
}

// Of a recording that has no second without a gap, nothing would be left.
TEST(RecordingsWithGaps, StayWholeWhereTheGapsAreShortOrEverywhere) {
  std::vector<std::string> warnings;
  const auto pause = [](double period, double silent) {
    return [=](double t) { return std::fmod(t + 0.005, period) < silent; };
  };
  EXPECT_EQ(cut_at_gaps(make_recording(), &warnings).size(), 1u);
  EXPECT_EQ(cut_at_gaps(lose(make_recording(), pause(0.5, 0.08)), &warnings).size(), 1u);
  EXPECT_EQ(cut_at_gaps(lose(make_recording(), pause(0.5, 0.2)), &warnings).size(), 1u);
  EXPECT_TRUE(warnings.empty());
}

TEST(LongRecordings, AreAveragedOnlyWhenTheyDoNotFitAndNeverBelowTheLeastRate) {
  EXPECT_EQ(find_averaging(0.5 * kMostNumbers, 1000.0), 1u);
  EXPECT_EQ(find_averaging(3.0 * kMostNumbers, 1000.0), 3u);
  EXPECT_EQ(find_averaging(100.0 * kMostNumbers, 1000.0), 8u);  // 125 Hz
  EXPECT_EQ(find_averaging(100.0 * kMostNumbers, 100.0), 1u);
}

TEST(LongRecordings, AreAveragedWhileTheyAreReadAndAcrossNoGap) {
  const std::string path = (std::filesystem::temp_directory_path() / "hrp_long_recording.csv").string();
  std::ofstream file(path);
  file << "time,a\n";
  for (int k = 0; k < 10; ++k) file << 0.001 * k << "," << k << "\n";
  for (int k = 0; k < 4; ++k) file << 1.0 + 0.001 * k << "," << 100 + k << "\n";
  file.close();
  std::vector<std::string> warnings;
  const Table table = read_csv_averaged(path, 4, &warnings);
  ASSERT_EQ(table.rows(), 4u);  // 4, 4, and 2 before the gap; 4 behind it
  EXPECT_DOUBLE_EQ(table.columns[1][0], 1.5);
  EXPECT_DOUBLE_EQ(table.columns[1][2], 8.5);
  EXPECT_DOUBLE_EQ(table.columns[1][3], 101.5);
  EXPECT_NEAR(table.columns[0][3], 1.0015, 1e-9);
  EXPECT_EQ(table.lines[3], 12);
}

TEST(LongRecordings, ShapeOfATextIsKnownFromItsBegin) {
  const std::string path = (std::filesystem::temp_directory_path() / "hrp_long_shape.csv").string();
  std::ofstream file(path);
  file << "time,a,b\n";
  for (int k = 0; k < 5000; ++k) file << 0.002 * k << ",1.25,3.5\n";
  file.close();
  const CsvShape shape = probe_csv(path);
  EXPECT_EQ(shape.columns, 3.0);
  EXPECT_NEAR(shape.rate, 500.0, 1.0);
  EXPECT_NEAR(shape.rows, 5000.0, 500.0);  // later lines have a digit or two more
}

// A search by simulation of twenty minutes of an arm would take an hour. Torques along the motion are judged on all of
// it.
TEST(LongRecordings, AreFittedBySimulationInTheirRichestTenMinutesOfAllJoints) {
  Experiment e = make_simulated_experiment("long_fit", kArm, {"shoulder", "elbow"}, {});
  const Problem shorter = make_problem(e, 2);
  EXPECT_FALSE(FittedPart(shorter, shorter).is_cut());
  const std::vector<Recording> once = e.recordings;
  while (calc_joint_seconds(e) < 700.0) e.recordings.insert(e.recordings.end(), once.begin(), once.end());
  const Problem longer = make_problem(e, 2);
  const FittedPart part(longer, longer);
  ASSERT_TRUE(part.is_cut());
  EXPECT_LE(part.seconds(), 300.0 + 10.0);  // 600 joint-seconds of two joints, to a piece
  EXPECT_GT(part.seconds(), 200.0);
  EXPECT_FALSE(part.problem().train.empty());
  EXPECT_FALSE(part.problem().validate.empty());
}

}  // namespace
}  // namespace hrp::diagnosis
