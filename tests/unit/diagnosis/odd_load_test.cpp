// SPDX-License-Identifier: BSD-3-Clause
// A load that the robot carries in one recording only is told from physics of the machine.
#include <gtest/gtest.h>

#include <algorithm>

#include "diagnosis/conventions/odd_load.h"
#include "diagnosis/data/stretches.h"
#include "diagnosis/diagnose_recordings.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

constexpr double kMass = 1.0;  // [kg], as much as the fore arm

Hypothesis make_loaded() {
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kPayload, kFore, {kMass, 0.3, 0.0, 0.0, 0.0}});
  return hidden;
}

// The arm without a load, but for these recordings.
Experiment make_mixed(const std::string& name, const std::vector<size_t>& loaded) {
  Experiment e = simulate_arm(name, make_arm_drives());
  const Experiment with = simulate_arm(name + "_loaded", make_loaded());
  for (size_t r : loaded) e.recordings[r] = with.recordings[r];
  e.scenario.drive = "effort";
  return e;
}

std::optional<OddLoad> find(const Experiment& e) { return find_odd_load(make_torque_data(e)); }

TEST(OddLoad, ALoadInOneTrainingRecordingIsFoundThereAndLeftOut) {
  const Experiment e = make_mixed("odd_load_train", {0});
  const std::optional<OddLoad> odd = find(e);
  ASSERT_TRUE(odd);
  ASSERT_EQ(odd->parts.size(), 1u);
  EXPECT_EQ(odd->parts[0].file, e.recordings[0].spec.file);
  EXPECT_TRUE(odd->parts[0].whole);
  EXPECT_EQ(odd->link, kFore);
  EXPECT_NEAR(odd->mass, kMass, 3.0 * odd->std);
  EXPECT_TRUE(odd->leave_out);
  EXPECT_EQ(leave_out(e, *odd).recordings.size(), e.recordings.size() - 1);
}

// Without the only held-out recording nothing could be judged: the load is said, and the recording stays.
TEST(OddLoad, ALoadInTheOnlyHeldOutRecordingIsSaidAndStays) {
  const std::optional<OddLoad> odd = find(make_mixed("odd_load_held", {2}));
  ASSERT_TRUE(odd);
  EXPECT_FALSE(odd->leave_out);
}

// The arm takes up the load at this time [s] of a recording.
Experiment make_taken_up(const std::string& name, const std::vector<double>& times) {
  Experiment e = simulate_arm(name, make_arm_drives());
  const Experiment with = simulate_arm(name + "_loaded", make_loaded());
  e.scenario.drive = "effort";
  for (size_t r = 0; r < e.recordings.size(); ++r) {
    for (size_t k = 0; k < e.recordings[r].size(); ++k) {
      for (size_t j = 0; j < e.recordings[r].joints.size() && e.recordings[r].time[k] > times[r]; ++j) {
        for (size_t q = 0; q < kQuantities; ++q)
          e.recordings[r].joints[j].signal[q][k] = with.recordings[r].joints[j].signal[q][k];
      }
    }
  }
  return e;
}

// Nothing said so before, and friction and rotors took a part of it.
TEST(OddLoad, ALoadThatIsTakenUpWithinARecordingIsFoundFromThenOn) {
  const Experiment e = make_taken_up("odd_load_taken", {100.0, 3.0, 100.0});
  const std::optional<OddLoad> odd = find(e);
  ASSERT_TRUE(odd);
  ASSERT_EQ(odd->parts.size(), 1u);
  EXPECT_EQ(odd->parts[0].file, e.recordings[1].spec.file);
  EXPECT_FALSE(odd->parts[0].whole);
  EXPECT_NEAR(odd->parts[0].begin, 3.0, 2.0 * 6.0 / 16.0);  // two of 16 pieces: the filter blurs the instant
  EXPECT_EQ(odd->link, kFore);
  EXPECT_NEAR(odd->mass, kMass, 3.0 * odd->std);
  EXPECT_TRUE(odd->leave_out);
  for (const Recording& r : leave_out(e, *odd).recordings)
    EXPECT_TRUE(r.spec.file != odd->parts[0].file || r.time.back() < 3.0);
}

// A short recording has no piece left that is long enough: all training recordings were gone, and the search crashed.
TEST(OddLoad, WhatIsLeftOfAShortRecordingIsTooShortToLeaveAnythingOut) {
  Experiment e = make_taken_up("odd_load_short", {0.9, 100.0, 100.0});
  e.recordings[0] = cut_recording(e.recordings[0], 0, static_cast<size_t>(1.8 / e.sample_time));
  e.recordings.erase(e.recordings.begin() + 1);  // one to train with, one held out
  const std::optional<OddLoad> odd = find(e);
  ASSERT_TRUE(odd);
  EXPECT_FALSE(odd->leave_out);
}

// Efforts in another unit: the second half of the motion asks for a load of many times the machine.
TEST(OddLoad, ALoadThatTheMachineCannotCarryIsNone) {
  Experiment e = make_taken_up("odd_load_units", {3.0, 100.0, 100.0});
  ASSERT_TRUE(find(e));
  for (Recording& r : e.recordings) {
    for (JointColumns& joint : r.joints) {
      for (double& effort : joint.signal[static_cast<int>(Quantity::kEffort)]) effort *= 1000.0;
    }
  }
  EXPECT_FALSE(find(e));
}

TEST(OddLoad, ALoadThatIsTakenUpInEachRecordingIsFoundInEach) {
  const std::optional<OddLoad> odd = find(make_taken_up("odd_load_each", {2.0, 3.0, 4.0}));
  ASSERT_TRUE(odd);
  EXPECT_EQ(odd->parts.size(), 3u);
  EXPECT_NEAR(odd->mass, kMass, 3.0 * odd->std);
}

TEST(OddLoad, FrictionAndALoadThatIsAlwaysThereAreNone) {
  EXPECT_FALSE(find(make_mixed("odd_load_none", {})));
  EXPECT_FALSE(find(make_mixed("odd_load_all", {0, 1, 2})));
}

// One model for all recordings spread the load over friction and rotors before, and named it nowhere.
TEST(OddLoad, TheReportNamesTheLoadWithItsRecordingAndTheModelIsThatOfTheOthers) {
  const Experiment e = make_mixed("odd_load_report", {0});
  DiagnosisOptions options;
  options.patience = 0.02;
  const Reports reports = diagnose_recordings(
      e, options, [](const std::string&) {}, [](const Reports&) {});
  int loads = 0;
  for (const Json& f : reports.report["findings"]) {
    if (f["effect"] != "payload") continue;
    ++loads;
    ASSERT_TRUE(f.contains("only_in")) << f["statement"];
    EXPECT_EQ(f["only_in"][0], e.recordings[0].spec.name);
  }
  EXPECT_EQ(loads, 1);
  const std::string summary = reports.report["summary"], only = "only in " + e.recordings[0].spec.name;
  EXPECT_NE(summary.find(only), std::string::npos) << summary;
}

}  // namespace
}  // namespace hrp::diagnosis
