// SPDX-License-Identifier: BSD-3-Clause
// The rollout and the fit on a pendulum made here: what was put in comes out.
#include <gtest/gtest.h>

#include "diagnosis/findings/suspect_predictions.h"
#include "diagnosis/fixed_base.h"
#include "diagnosis/report/report.h"
#include "diagnosis/search/hum.h"
#include "diagnosis/search/step_check.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

constexpr const char* kUrdf = R"(<robot name="arm"><link name="base"/><link name="l1"><inertial><origin xyz="0 0 -0.2"/>
<mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial></link>
<joint name="j1" type="revolute"><parent link="base"/><child link="l1"/><origin xyz="0 0 0"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="50" velocity="10"/></joint></robot>)";

Experiment make_experiment(const std::string& name, const Hypothesis& hidden) {
  return make_simulated_experiment(name, kUrdf, {"j1"}, hidden);
}

TEST(Diagnosis, FindsNothingWhereNothingIsHidden) {
  const Experiment e = make_experiment("none", {});
  const Problem problem = make_problem(e, 1);
  const Outcome outcome = search(problem, [](const std::string&) {});
  EXPECT_FALSE(outcome.mismatch);
  EXPECT_NEAR(outcome.nominal.rms, 1.0, 0.05);  // 3600 readings: 1.2 % of chance, start of the rollout
}

TEST(Diagnosis, RecoversViscousFriction) {
  const Experiment e = make_experiment("viscous", {{EffectId::kViscous, 0, {0.7}}});
  const Problem problem = make_problem(e, 1);
  const Outcome outcome = search(problem, [](const std::string&) {});
  ASSERT_TRUE(outcome.explained);
  ASSERT_EQ(outcome.chosen.hypothesis.size(), 1u);
  EXPECT_EQ(outcome.chosen.hypothesis[0].id, EffectId::kViscous);
  EXPECT_NEAR(outcome.chosen.hypothesis[0].p[0], 0.7, 0.01);
  EXPECT_LT(outcome.chosen.rms, 1.2);
}

// [N m] What the drive of kUrdf gives beyond what the motion and the weight take, from readings at samples k - 1 to k
// + 1.
double calc_friction(const std::vector<double>& y, const std::vector<double>& time, size_t k) {
  const double inertia = 0.02 + 2.0 * 0.2 * 0.2, weight = 2.0 * 9.81 * 0.2;
  const double qdd = (y[(k + 1) * kQuantities + 1] - y[(k - 1) * kQuantities + 1]) / (time[k + 1] - time[k - 1]);
  return y[k * kQuantities + 2] - inertia * qdd - weight * std::sin(y[k * kQuantities]);
}

// Bristles carry what the law of the level says at the speed of the moment once the joint has slid by more than they
// bend: braking and speeding up alike.
TEST(DiagnosisRollout, SlidingFrictionIsWhatItsLawSaysHoweverFastSpeedChanges) {
  constexpr double kCoulomb = 1.0, kStatic = 3.0, kSpeed = 0.3, kBend = 2e-3;
  const Experiment e = make_experiment("sliding", {});
  const Plant plant = make_plant(e, {{EffectId::kStribeck, 0, {kCoulomb, kStatic, kSpeed, 0.0, kBend}}});
  const Recording& recording = e.recordings[0];
  RolloutOptions fine;
  fine.max_step = 0.0001;
  std::vector<double> y;
  ASSERT_TRUE(simulate_recording(plant, recording, smooth_recording(e, recording), fine, &y));
  double turned = 0.0;
  int compared = 0;
  for (size_t k = 100; k + 2 < recording.size(); ++k) {
    const double v = y[k * kQuantities + 1], q = y[k * kQuantities];
    if (v * y[(k - 1) * kQuantities + 1] <= 0.0) turned = q;
    if (std::abs(q - turned) < 8.0 * kBend || std::abs(v) < 0.1) continue;  // e^-8 of the bend is left to go
    const double level = kCoulomb + (kStatic - kCoulomb) * std::exp(-v * v / kSpeed / kSpeed);
    // 2 %: differences of a rate over two samples of 5 ms; a level that lags by 2 mrad is 20 % off at such speeds.
    EXPECT_NEAR(calc_friction(y, recording.time, k) * (v > 0.0 ? 1.0 : -1.0), level, 0.02 * kStatic);
    ++compared;
  }
  EXPECT_GT(compared, 300);
}

TEST(DiagnosisRollout, AJointAtItsLimitIsTrustedNoMoreThanIntegratorsAgree) {
  Experiment e = make_experiment("limit", {});
  for (size_t k = 400; k < 440; ++k) e.recordings[0].joints[0].signal[2][k] = 50.0;  // [N m] the drive's limit
  const Problem problem = make_problem(e, 1);
  EXPECT_EQ(get_weight(problem, 0, 399, 0), problem.weights[0]);
  EXPECT_LT(get_weight(problem, 0, 420, 0), problem.weights[0]);
  EXPECT_LT(get_weight(problem, 0, 460, 0), problem.weights[0]);  // 0.15 s until the servo has settled
  EXPECT_EQ(get_weight(problem, 0, 480, 0), problem.weights[0]);
  EXPECT_EQ(get_weight(problem, 1, 420, 0), problem.weights[0]);
}

// Servos that log neither efforts nor the rates of their commands: what they gave is known from positions alone.
TEST(StepCheck, WhatPhysicsLeavesIsNotBlamedOnTheStep) {
  const Experiment e = make_experiment("steps", {{EffectId::kCoulomb, 0, {0.5, 0.0, 1e-3}}});
  EXPECT_TRUE(find_suspect_joints(make_problem(e, 1)).empty());
}

TEST(StepCheck, FindingsAtASuspectJointAreAmbiguousAndThoseElsewhereStand) {
  const Experiment e = make_experiment("suspect", {});
  nlohmann::ordered_json report = {
      {"warnings", nlohmann::ordered_json::array()},
      {"unexplained", {{{"where", {{"joint", "j1"}}}, {"depends_on", {"time"}}, {"statement", "54 N m"}}}}};
  for (const char* joint : {"j1", "j2"})
    report["findings"].push_back({{"where", {{"joint", joint}}}, {"grade", "certain"}, {"statement", ""}});
  doubt_suspects(e, {{0, 40.0, 60.0, true}}, &report);
  EXPECT_EQ(report["findings"][0]["grade"], "ambiguous");
  EXPECT_EQ(report["findings"][1]["grade"], "certain");
  EXPECT_EQ(report["warnings"].size(), 1u);
  EXPECT_TRUE(report["unexplained"][0]["depends_on"].empty());
}

// The elbow's readings as a log has them that meets a hum in the same phase every time.
TEST(StepCheck, BesideAServoThatHumsTheOtherJointIsJudgedAndTheHumIsNoPhysics) {
  Experiment e = simulate_arm("hum", {{EffectId::kRotorInertia, kShoulder, {0.5}}});
  EXPECT_TRUE(find_hum(e).humming.empty());
  for (Recording& r : e.recordings) {
    for (size_t k = 0; k < r.size(); ++k) {
      r.joints[kElbow].signal[1][k] -= 10.0;
      r.joints[kElbow].signal[2][k] = 50.0;
    }
  }
  const Hum hum = find_hum(e);
  EXPECT_EQ(hum.humming, std::vector<int>{kElbow});
  EXPECT_EQ(hum.shaken, std::vector<int>{kElbow});
  const Reports reports = diagnose_fixed_base(make_problem(e, 1), [](const std::string&) {});
  bool rotor = false;
  for (const auto& f : reports.report["findings"]) {
    EXPECT_EQ(f["where"]["joint"], "shoulder");
    rotor = rotor || f["effect"] == "rotor_inertia";
  }
  EXPECT_TRUE(rotor);
}

// The shoulder reads 0.02 rad/s off its rate, and its servo's damping of 15 N m s/rad adds -0.3 N m to every effort.
TEST(StepCheck, WhatAHumLeavesInANeighboursLogIsNoConstantTorque) {
  Experiment e = simulate_arm("hum_neighbour", {{EffectId::kRotorInertia, kShoulder, {0.5}}});
  const double kd = make_plant(e, {}).laws[kShoulder].kd, dv = 0.02;
  ASSERT_GT(kd, 1.0);
  for (Recording& r : e.recordings) {
    for (size_t k = 0; k < r.size(); ++k) {
      r.joints[kElbow].signal[1][k] -= 10.0;
      r.joints[kElbow].signal[2][k] = 50.0;
      r.joints[kShoulder].signal[1][k] += dv;
      r.joints[kShoulder].signal[2][k] -= kd * dv;
    }
  }
  const Reports reports = diagnose_fixed_base(make_problem(e, 1), [](const std::string&) {});
  ASSERT_EQ(reports.report["findings"].size(), 1u);
  EXPECT_EQ(reports.report["findings"][0]["effect"], "rotor_inertia");
}

TEST(DiagnosisRollout, WithoutEffortsAndCommandedRatesTheServosLawTellsItsLimit) {
  Experiment e = make_experiment("limit_by_law", {});
  for (Recording& recording : e.recordings) {
    recording.joints[0].signal[static_cast<int>(Quantity::kEffort)].clear();
    recording.joints[0].command_rate.clear();
  }
  for (size_t k = 400; k < 440; ++k) e.recordings[0].joints[0].command[k] += 0.5;  // [rad] 100 N m for a limit of 50
  const Problem problem = make_problem(e, 1);
  EXPECT_LT(get_weight(problem, 0, 420, 0), problem.weights[0]);
  EXPECT_EQ(get_weight(problem, 1, 420, 0), problem.weights[0]);
}

TEST(Diagnosis, ReadingsThatNothingWasComparedWithAreSaid) {
  Experiment e = make_experiment("unused", {});
  for (Recording& recording : e.recordings) {
    for (const char* column : {"/wrench/hand/force/x", "/wrench/hand/force/y", "/base/pose/position/x"})
      recording.other[column].assign(recording.size(), 0.0);
  }
  const Reports reports = diagnose(make_problem(e, 1), [](const std::string&) {});
  EXPECT_EQ(reports.report["verdict"], "no_mismatch");
  const std::string warning = reports.report["warnings"].back();
  EXPECT_NE(warning.find("not compared with any prediction: /base/pose, /wrench/hand;"), std::string::npos);
}

TEST(Diagnosis, DoesNotDependOnTheNumberOfThreads) {
  const Experiment e = make_experiment("threads", {{EffectId::kRotorInertia, 0, {0.05}}});
  Reports reports[2];
  for (int jobs = 1; jobs <= 2; ++jobs) {
    const Problem problem = make_problem(e, jobs);
    reports[jobs - 1] = diagnose(problem, [](const std::string&) {});
  }
  EXPECT_EQ(reports[0].report.dump(), reports[1].report.dump());
  EXPECT_EQ(reports[0].report["findings"][0]["effect"], "rotor_inertia");
}

}  // namespace
}  // namespace hrp::diagnosis
