// SPDX-License-Identifier: BSD-3-Clause
// The next experiment of robots with many effects, and of robots that are driven by efforts: explanations are compared
// by the torque that is missing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/torque/intervals.h"
#include "diagnosis/next/limits.h"
#include "diagnosis/next/proposal_parts.h"
#include "diagnosis/next/propose.h"
#include "diagnosis/next/torque_propose.h"
#include "diagnosis/next/torque_rows.h"
#include "diagnosis/next/torque_worlds.h"
#include "diagnosis/next/trial_motion.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

const Progress kQuietly = [](const std::string&) {};

Json make_entry(const std::string& effect, const std::string& joint, const std::string& parameter, double value) {
  return {{"effect", effect},
          {"where", {{"joint", joint}}},
          {"parameters", {{parameter, {{"value", value}, {"ci95", {0.8 * value, 1.2 * value}}}}}}};
}

// Friction and rotors of both drives, as a report lists them; nothing is said to be ambiguous.
Json make_many_report() {
  Json findings = Json::array();
  for (const Effect& effect : make_arm_drives()) {
    Json one = make_entry(get_effect(effect.id).name, kArmJoints[static_cast<size_t>(effect.place.index)],
                          list_infos(effect.id)[0].name, effect.p[0]);
    one["grade"] = "supported";
    findings.push_back(one);
  }
  return {{"verdict", "mostly_explained"}, {"findings", findings}};
}

// The elbow may have no viscous friction, and a spring instead of its Coulomb friction.
Json make_open_report() {
  Json report = make_many_report();
  for (Json& finding : report["findings"]) {
    if (finding["where"]["joint"] != "elbow") continue;
    if (finding["effect"] == "viscous_friction") finding["grade"] = "ambiguous";
    if (finding["effect"] == "coulomb_friction")
      finding["alternatives"] = {make_entry("parallel_spring", "elbow", "stiffness", 1.0)};
  }
  return report;
}

NextOptions make_options() {
  NextOptions options;
  options.seconds = 5.0;
  options.count = 1;
  return options;
}

// Both joints creep at one speed, so that what grows with speed and what does not look the same.
Experiment make_slow_arm(const std::string& name) {
  Experiment e = simulate_arm(name, {});
  TestNoise noise;
  const double sigma[] = {2e-5, 0.002, 0.02};
  for (Recording& r : e.recordings) {
    for (size_t k = 0; k < r.size(); ++k) {
      for (auto& joint : r.joints) {
        const double t = r.time[k] - r.time[0], back = t < 3.0 ? 1.0 : -1.0;
        joint.command[k] = 0.2 * (t < 3.0 ? t : 6.0 - t);
        joint.command_rate[k] = 0.2 * back;
      }
    }
    for (auto& joint : r.joints) {
      joint.signal[0] = joint.command;
      joint.signal[1] = joint.command_rate;
    }
    SmoothRecording smooth = smooth_recording(e, r);
    std::vector<double> y;
    RolloutOptions fine;
    fine.max_step = 0.0002;
    EXPECT_TRUE(simulate_recording(make_plant(e, make_arm_drives()), r, smooth, fine, &y));
    for (size_t k = 0; k < r.size(); ++k) {
      for (size_t c = 0; c < 6; ++c)
        r.joints[c / 3].signal[c % 3][k] = y[std::max(k, smooth.start) * 6 + c] + sigma[c % 3] * noise.draw();
    }
  }
  return e;
}

TEST(NextByTorque, FasterMotionTellsWhetherFrictionGrowsWithSpeed) {
  const Experiment e = make_slow_arm("next_torque_speed");
  const Next next = propose_by_torque(e, make_open_report(), make_options(), kQuietly);
  ASSERT_EQ(next.proposals.size(), 1u) << next.nothing;
  const Proposal& p = next.proposals[0];
  const auto viscous = std::find_if(p.expected.begin(), p.expected.end(),
                                    [](const Expected& x) { return x.label == "no viscous_friction@elbow"; });
  ASSERT_NE(viscous, p.expected.end());
  EXPECT_GT(viscous->probability, 0.9);
  const double fastest = *std::max_element(p.commands.velocity[kElbow].begin(), p.commands.velocity[kElbow].end());
  EXPECT_GT(fastest, 3.0 * 0.2);
}

// Of a width of 5, a noise of 3 and 4 of a friction that is uneven over a turn; 12 more in a width of 13 stay.
TEST(NextByTorque, OnlyNoiseAndTheUnseenPartOfATurnBecomeNarrower) {
  EXPECT_NEAR(calc_expected_width(5.0, {3.0, 4.0}, {0.3, 4.0}), std::hypot(0.3, 4.0), 1e-12);
  EXPECT_NEAR(calc_expected_width(5.0, {3.0, 4.0}, {3.0, 2.0}), std::hypot(3.0, 2.0), 1e-12);
  EXPECT_NEAR(calc_expected_width(13.0, {3.0, 4.0}, {0.0, 0.0}), 12.0, 1e-12);
  EXPECT_NEAR(calc_expected_width(5.0, {30.0, 4.0}, {15.0, 4.0}), 2.5, 1e-12);  // no part is wider than the whole
  EXPECT_NEAR(calc_expected_width(5.0, {3.0, 0.0, 4.0}, {0.0, 0.0, 8.0}), 8.0,
              1e-12);  // the time of a sample may matter more
  EXPECT_NEAR(calc_expected_width(5.0, {4.0, 0.0, 0.0, 3.0}, {0.0, 0.0, 0.0, 3.0}), 3.0,
              1e-12);  // masses are known to 2 %, whatever moves
}

// Of a rotor, a torque constant that is 2 % off takes 2 % of all that accelerates with it, links included. Of a level
// of dry friction, the limits leave a part of the turn unseen. No repetition of a motion lowers either.
TEST(NextByTorque, WhatNoMotionLowersIsStatedBesideEveryInterval) {
  const Experiment e = simulate_arm("next_torque_least", make_arm_drives());
  const auto list = [&](const char* reach) {
    NextOptions options = make_options();
    options.limits = {reach};
    return propose_by_torque(e, make_open_report(), options, kQuietly).proposals.at(0).intervals;
  };
  const std::vector<ExpectedInterval> narrow = list("reach=0.3"), wide = list("reach=1");
  const auto find = [](const std::vector<ExpectedInterval>& all, const std::string& label) {
    return *std::find_if(all.begin(), all.end(), [&](const ExpectedInterval& x) { return x.label == label; });
  };
  for (const ExpectedInterval& x : wide) EXPECT_TRUE(x.least > 0.0 && x.least <= x.after) << x.label;
  // The weight varies against the acceleration here, which takes a part of it off.
  EXPECT_GT(find(wide, "rotor_inertia@elbow").least, kNinetyFive * 0.01 * find(wide, "rotor_inertia@elbow").value);
  EXPECT_LT(find(wide, "coulomb_friction@elbow").least, find(narrow, "coulomb_friction@elbow").least);
}

// An effort that is late by half a sample looks like friction: along a sine, the rate of the inertia's torque is
// opposite to the speed. More samples do not help, so the expected interval of a quick motion must contain it.
TEST(NextByTorque, TheTimeOfASampleLimitsWhatAQuickMotionTellsOfFriction) {
  const auto calc_width = [](double frequency) {  // of J = 0.5 kg m^2, 0.8 rad, friction fitted alone
    constexpr long kSamples = 2000;
    Eigen::MatrixXd x(kSamples, 1);
    Eigen::VectorXd effort(kSamples), rate(kSamples);
    const double w = 2.0 * M_PI * frequency;
    for (long k = 0; k < kSamples; ++k) {
      const double t = 0.005 * static_cast<double>(k);
      x(k, 0) = 0.8 * w * std::cos(w * t);
      effort[k] = -0.4 * w * w * std::sin(w * t);
      rate[k] = -0.4 * w * w * w * std::cos(w * t);
    }
    return std::sqrt(calc_considered_variance(sum_considered(x, effort, rate), 0.005, 0.02)[0]);
  };
  EXPECT_NEAR(calc_width(2.0), 0.0025 * 0.5 * std::pow(4.0 * M_PI, 2),
              1e-3);  // half a sample x J w^2 = 0.197 N m s/rad
  EXPECT_NEAR(calc_width(2.0) / calc_width(0.5), 16.0, 0.1);
}

// Friction is uneven over a turn, and no more than two of the 6.28 rad can be seen here.
TEST(NextByTorque, AMotionThatSeesAThirdOfATurnLeavesMostOfTheDoubtAboutDryFriction) {
  const Experiment e = simulate_arm("next_torque_turn", make_arm_drives());
  NextOptions options = make_options();
  options.count = 2;
  options.limits = {"reach=1"};
  const Next next = propose_by_torque(e, make_open_report(), options, kQuietly);
  ASSERT_EQ(next.proposals.size(), 2u) << next.nothing;
  for (size_t i = 0; i < next.proposals[0].intervals.size(); ++i) {
    const ExpectedInterval& one = next.proposals[0].intervals[i];
    const double seen = one.label.find("coulomb") != std::string::npos ? 2.0 : 2.0 * M_PI;  // [rad]
    EXPECT_GE(one.after, kNinetyFive * calc_unseen_std(one.value, seen) - 1e-9) << one.label;
    EXPECT_EQ(next.proposals[1].intervals[i].after, one.after) << one.label;  // held out: no value is fitted to it
  }
}

TEST(NextByTorque, EveryAlternativeOfTheReportIsAQuestion) {
  const OpenTerms terms = find_open_terms(simulate_arm("next_torque_open", make_arm_drives()), make_open_report());
  ASSERT_EQ(terms.questions.size(), 2u);
  EXPECT_EQ(terms.questions[0].label, "no viscous_friction@elbow");
  EXPECT_EQ(terms.questions[1].label, "parallel_spring@elbow instead of coulomb_friction@elbow");
  EXPECT_EQ(terms.values.size(), 6u);
}

// At rest a level of friction and a constant torque cancel: whatever their values, they say nothing about a motion.
TEST(NextByTorque, TermsOfAJointThatStoodStillAreNoValues) {
  Experiment e = simulate_arm("next_torque_still", make_arm_drives());
  for (Recording& r : e.recordings) {
    for (auto* column : {&r.joints[kElbow].command, &r.joints[kElbow].signal[0]})
      std::fill(column->begin(), column->end(), e.recordings[0].joints[kElbow].command[0]);
  }
  Json report = make_many_report();
  report["model"] = report["findings"];
  Json said = Json::array();
  for (const Json& finding : report["findings"]) {
    if (finding["where"]["joint"] != "elbow" || finding["effect"] == "rotor_inertia") said.push_back(finding);
  }
  report["findings"] = said;
  const Hypothesis best = find_open_terms(e, report).best.hypothesis;
  EXPECT_EQ(std::count_if(best.begin(), best.end(), [](const Effect& x) { return x.place.index == kShoulder; }), 3);
  ASSERT_EQ(std::count_if(best.begin(), best.end(), [](const Effect& x) { return x.place.index == kElbow; }), 1);
  EXPECT_EQ(best.back().id, EffectId::kRotorInertia);  // what the report names is a value
}

// What a recording knows is what the same motion would tell once more. Filters and folds change it little.
TEST(NextByTorque, ARepeatedRecordingTellsAsMuchAsItsShare) {
  const Experiment e = simulate_arm("next_torque_twice", make_arm_drives());
  const OpenTerms terms = find_open_terms(e, make_open_report());
  const TorqueRows rows(terms);
  const Eigen::MatrixXd known = rows.calc_known(terms.best);
  Eigen::MatrixXd told = Eigen::MatrixXd::Zero(known.rows(), known.cols());
  for (size_t r = 0; r < 2; ++r) {  // the training recordings
    Experiment one = e;
    one.recordings = {e.recordings[r]};
    MotionRows motion;
    ASSERT_TRUE(rows.measure(one, &motion));
    told += rows.compare(motion, terms.best, terms.best).fisher;
  }
  for (long i = 0; i < known.rows(); ++i) EXPECT_NEAR(told(i, i) / known(i, i), 1.0, 0.2) << i;
}

// Losses and inertias at their upper ends together need more effort than each alone.
TEST(NextByTorque, MotionsKeepTheirLimitsWithAllValuesAtTheEndsOfTheirIntervals) {
  const Experiment e = simulate_arm("next_torque_limits", make_arm_drives());
  NextOptions options = make_options();
  options.limits = {"elbow.upper=0.25", "speed=1.5", "shoulder.effort=20"};
  const Next next = propose_by_torque(e, make_open_report(), options, kQuietly);
  ASSERT_FALSE(next.proposals.empty()) << next.nothing;
  Experiment bare = e;
  bare.recordings.clear();
  const Proposal& p = next.proposals[0];
  const auto motion = make_trial_motion(bare, e.recordings[0], p.commands, {});
  for (const double factor : {0.8, 1.0, 1.2}) {
    Hypothesis drives = make_arm_drives();
    for (Effect& effect : drives) effect.p[0] *= factor;
    std::vector<double> y;
    ASSERT_TRUE(simulate_trial(*motion, drives, &y));
    for (size_t k = motion->problem.smooth[0].start; k < p.commands.time.size(); ++k) {
      EXPECT_LE(y[k * 6 + 3], 0.25);
      EXPECT_LE(std::abs(y[k * 6 + 1]), 1.5 / 0.9);
      EXPECT_LE(std::abs(y[k * 6 + 2]), 20.0);
    }
  }
}

TEST(NextByTorque, TheNumberOfSimulationsOfAChosenMotionIsBounded) {
  const OpenTerms terms = find_open_terms(simulate_arm("next_torque_worlds", make_arm_drives()), make_open_report());
  const std::vector<TorqueWorld> worlds = list_torque_worlds(terms, {0, 1});
  ASSERT_EQ(worlds.size(), 6u);
  EXPECT_TRUE(worlds[0].side.hypothesis.empty());
  EXPECT_NEAR(worlds[2].side.hypothesis[0].p[0], 0.8 * 0.8, 1e-9);  // viscous friction of the shoulder, lower end
  EXPECT_NEAR(worlds[3].side.hypothesis[0].p[0], 1.2 * 0.8, 1e-9);
}

// Nobody knows the gains, but everybody's controller can follow a motion. It begins at rest, where the drive carries
// the weight: 2 kg at 0.2 m and 1 kg at 0.55 m, which pull in the direction of a positive angle.
TEST(NextByTorque, ARobotDrivenByEffortsGetsAMotionWithTheEffortsThatItNeeds) {
  Experiment e = simulate_arm("next_torque_effort", make_arm_drives());
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) {
    for (auto& joint : r.joints) {
      joint.command.clear();
      joint.command_rate.clear();
    }
  }
  const Next next = propose(e, make_open_report(), make_options(), kQuietly);
  ASSERT_EQ(next.proposals.size(), 1u) << next.nothing;
  const Proposal& p = next.proposals[0];
  ASSERT_EQ(p.effort.size(), 2u);
  EXPECT_NEAR(p.effort[kShoulder].front(), -9.81 * (2.0 * 0.2 + 1.0 * 0.55), 0.3);
  EXPECT_TRUE(p.stop.empty());  // nothing tells how far it will be from the motion
  NextOptions weak = make_options();
  weak.limits = {"shoulder.effort=5"};
  EXPECT_NE(propose(e, make_open_report(), weak, kQuietly).nothing.find("No motion is safe"), std::string::npos);
}

// 200 N m/rad times 0.15 rad is 30 N m.
TEST(NextByTorque, WithoutRecordedEffortsTheServoSaysWhatTheDriveGave) {
  Experiment e = simulate_arm("next_torque_servo", {});
  remove_effort_limits(&e);
  for (Recording& r : e.recordings) r.joints[kElbow].signal[2].clear();
  e.recordings[0].joints[kElbow].signal[0][0] = e.recordings[0].joints[kElbow].command[0] - 0.15;
  EXPECT_NEAR(make_limits(e, {}).joints[kElbow].effort, 2.0 * 30.0, 1e-9);
}

TEST(NextByTorque, WithoutAMotionTheReportsWordsSayWhichKindWouldTell) {
  Experiment e = simulate_arm("next_torque_words", {});
  e.scenario.drive = "motion";
  Json report = make_open_report();
  for (Json& finding : report["findings"]) {
    if (finding.contains("alternatives"))
      finding["alternatives"][0]["motion_that_would_tell"] = "constant speeds, slow and fast";
  }
  const Next next = propose(e, report, make_options(), kQuietly);
  EXPECT_FALSE(next.nothing.empty());
  ASSERT_EQ(next.words.size(), 1u);
  EXPECT_EQ(next.words[0], "elbow: coulomb_friction or parallel_spring: constant speeds, slow and fast");
}

}  // namespace
}  // namespace hrp::diagnosis
