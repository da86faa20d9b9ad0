// SPDX-License-Identifier: BSD-3-Clause
// The next experiment: motions that are proposed, what they are expected to tell, and what keeps them safe.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "common/base/diagnostics.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/next/ends.h"
#include "diagnosis/next/information.h"
#include "diagnosis/next/limits.h"
#include "diagnosis/next/plan_list.h"
#include "diagnosis/next/propose.h"
#include "diagnosis/next/safety.h"
#include "diagnosis/next/trial_motion.h"
#include "diagnosis/search/trial.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

const Progress kQuietly = [](const std::string&) {};

// One speed there and back: what grows with speed and what does not look the same but where the joint turns around.
// The recordings are those of a robot with `hidden`.
Experiment make_poor_experiment(const std::string& name, const std::string& urdf, const Hypothesis& hidden) {
  Experiment e = make_simulated_experiment(name, urdf, kArmJoints, {});
  TestNoise noise;
  const double sigma[] = {2e-5, 0.002, 0.02};
  for (Recording& r : e.recordings) {
    for (size_t k = 0; k < r.size(); ++k) {
      r.joints[kShoulder].command[k] = r.joints[kShoulder].command_rate[k] = 0.0;
      r.joints[kElbow].command[k] = 0.2 * (r.time[k] - r.time[0]) - 0.6;
      r.joints[kElbow].command_rate[k] = 0.2;
    }
    for (auto& joint : r.joints) {
      joint.signal[0] = joint.command;
      joint.signal[1] = joint.command_rate;
    }
    SmoothRecording smooth = smooth_recording(e, r);
    std::vector<double> y;
    RolloutOptions fine;
    fine.max_step = 0.0002;
    EXPECT_TRUE(simulate_recording(make_plant(e, hidden), r, smooth, fine, &y));
    for (size_t k = 0; k < r.size(); ++k) {
      for (size_t c = 0; c < 6; ++c)
        r.joints[c / 3].signal[c % 3][k] = y[std::max(k, smooth.start) * 6 + c] + sigma[c % 3] * noise.draw();
    }
  }
  return e;
}

Json make_entry(const std::string& effect, const std::string& parameter, double value) {
  return {{"effect", effect}, {"where", {{"joint", "elbow"}}}, {"parameters", {{parameter, {{"value", value}}}}}};
}

// "Viscous friction, or dry friction": 0.2 N m at 0.2 rad/s either way.
Json make_open_report() {
  Json finding = make_entry("viscous_friction", "coefficient", 1.0);
  finding["grade"] = "ambiguous";
  finding["alternatives"] = {make_entry("coulomb_friction", "level", 0.2)};
  return {{"verdict", "mostly_explained"}, {"findings", {finding}}};
}

Hypothesis make_viscous() { return {{EffectId::kViscous, kElbow, {1.0}}}; }

NextOptions make_options() {
  NextOptions options;
  options.seconds = 5.0;
  options.count = 1;
  return options;
}

TEST(NextExperiment, WhatAnotherValueExplainsDecidesNothing) {
  Comparison c;
  c.power = 400.0;
  c.count = 1000.0;
  c.fisher = Eigen::MatrixXd::Constant(1, 1, 100.0);
  c.along = Eigen::VectorXd::Constant(1, 200.0);  // r = 2 J: two units of the parameter
  EXPECT_NEAR(calc_projected_power(c, Eigen::MatrixXd::Zero(1, 1)), 0.0, 1e-6);
  // Recordings that already know the parameter as well as the motion will leave half of the difference.
  EXPECT_NEAR(calc_projected_power(c, Eigen::MatrixXd::Constant(1, 1, 100.0)), 200.0, 1e-6);
}

TEST(NextExperiment, ALargerDifferenceIsMoreLikelyToDecide) {
  EXPECT_LT(calc_decision_probability(10.0, 100.0, 1.0), 0.05);
  EXPECT_GT(calc_decision_probability(10000.0, 100.0, 1.0), 0.95);
  EXPECT_LT(calc_decision_probability(10000.0, 100.0, 10.0), calc_decision_probability(10000.0, 100.0, 1.0));
}

// A rival that is as dearer as the decision needs has just the probability up to which reports list it.
// A report needs 6 in chi2, or about 90: noise alone gives neither.
TEST(NextExperiment, ADifferenceFarBelowTheNoiseDecidesNothing) {
  for (double needed : {6.0, 90.0}) {
    double before = 0.0;
    for (double left : {1e-9, 1e-3, 0.1, 1.0, 10.0, 100.0, 1e3, 1e4}) {
      const double now = calc_decision_probability(left, needed, 1.0);
      EXPECT_GE(now, before) << left;
      EXPECT_TRUE(left > 0.2 || now < 0.01) << left;
      before = now;
    }
    EXPECT_GT(before, 0.99);
    EXPECT_NEAR(calc_decision_probability(needed, needed, 1.0), 0.5, 0.05);  // as likely more as less
  }
}

TEST(NextExperiment, ADecisionNeedsWhatTheReportNeedsToGiveUpARival) {
  const double odds = calc_odds(calc_dearer(kDetail), 0.0);
  EXPECT_NEAR(odds / (1.0 + odds), kDetail, 1e-12);
}

TEST(NextExperiment, EndsOfIntervalsAreThoseOfTheInformation) {
  const std::vector<Hypothesis> ends = list_ends(make_viscous(), Eigen::MatrixXd::Constant(1, 1, 1e4));
  ASSERT_EQ(ends.size(), 2u);
  // Standard deviation 1 / sqrt(1e4); the prior of half the value hardly narrows it.
  EXPECT_NEAR(ends[0][0].p[0], 1.0 - 0.0196, 1e-4);
  EXPECT_NEAR(ends[1][0].p[0], 1.0 + 0.0196, 1e-4);
}

// Motions as weak as the recordings show no more than these: the simulations under every explanation keep the limit.
TEST(NextExperiment, TheStatedLimitOfEffortHoldsHoweverWeakTheRecordingsAre) {
  Experiment e = simulate_arm("next_effort", {});
  for (Recording& r : e.recordings) {
    for (double& effort : r.joints[kElbow].signal[2]) effort = std::clamp(effort, -1.0, 1.0);
  }
  EXPECT_NEAR(make_limits(e, {}).joints[kElbow].effort, 0.9 * e.robot.tree.joint(kElbow).effort_limit, 1e-9);
}

TEST(NextExperiment, WithoutAStatedLimitEffortsGrowInSteps) {
  Experiment e = simulate_arm("next_steps", {});
  remove_effort_limits(&e);
  for (Recording& r : e.recordings) {
    for (double& effort : r.joints[kElbow].signal[2]) effort = std::clamp(effort, -1.0, 1.0);
  }
  e.recordings[0].joints[kElbow].signal[2][0] = 20.0;
  const Limits limits = make_limits(e, {});
  EXPECT_NEAR(limits.joints[kElbow].effort, 40.0, 1e-9);
  EXPECT_TRUE(std::any_of(limits.remarks.begin(), limits.remarks.end(), [](const std::string& remark) {
    return remark.find("elbow has no effort limit: twice the largest recorded effort is taken, 40") !=
           std::string::npos;
  }));
}

TEST(NextExperiment, EveryMotionBeginsAndEndsAtRestAndKeepsToPositionsAndSpeeds) {
  const Experiment e = simulate_arm("next_motions", {});
  const Limits limits = make_limits(e, {"speed=0.7", "elbow.upper=0.4"});
  for (int f = 0; f < static_cast<int>(Family::kCount); ++f) {
    MotionPlan plan;
    plan.family = static_cast<Family>(f);
    plan.moves = {1, 1};
    const Commands motion = make_motion(plan, limits);
    for (size_t j = 0; j < 2; ++j) {
      EXPECT_DOUBLE_EQ(motion.position[j].front(), limits.joints[j].start) << get_family_word(plan.family);
      EXPECT_DOUBLE_EQ(motion.position[j].back(), limits.joints[j].start);
      const auto [low, high] = std::minmax_element(motion.position[j].begin(), motion.position[j].end());
      EXPECT_GE(*low, limits.joints[j].lower - 1e-9);
      EXPECT_LE(*high, limits.joints[j].upper + 1e-9);
      for (double v : motion.velocity[j]) EXPECT_LE(std::abs(v), 0.7 + 1e-9);
    }
    EXPECT_LE(*std::max_element(motion.position[1].begin(), motion.position[1].end()), 0.4);
  }
}

TEST(NextExperiment, AJointThatMimicsMovesAsItsLeaderAndStaysWithinItsOwnLimits) {
  Experiment e = simulate_arm("next_mimic", {});
  JointSpec& elbow = e.robot.tree.links[kElbow + 1].joint;
  elbow.mimic = {kShoulder, -0.5, 0.1};
  elbow.lower = -1.0;
  elbow.upper = 1.0;
  const Limits limits = make_limits(e, {"speed=0.7"});
  for (const MotionPlan& plan : list_plans(e, limits, {1, 0}, 10.0)) {
    EXPECT_FALSE(plan.moves[kElbow]) << "it has no motion of its own";
    const Commands motion = make_motion(plan, limits);
    for (size_t k = 0; k < motion.time.size(); ++k) {
      // Both are products and sums of the same numbers.
      EXPECT_NEAR(motion.position[kElbow][k], -0.5 * motion.position[kShoulder][k] + 0.1, 1e-12);
      EXPECT_NEAR(motion.velocity[kElbow][k], -0.5 * motion.velocity[kShoulder][k], 1e-12);
      EXPECT_LE(std::abs(motion.position[kElbow][k]), 1.0);
    }
  }
}

// A drive that is weaker than stated lets its joint fall behind. By then the recording must be long enough to show it.
TEST(NextExperiment, AMotionGrowsSoSlowlyThatAWeakDriveLeavesARecording) {
  const Limits limits = make_limits(simulate_arm("next_growth", {}), {});
  for (int f = 0; f < static_cast<int>(Family::kCount); ++f) {
    MotionPlan plan;
    plan.family = static_cast<Family>(f);
    plan.moves = {1, 1};
    plan.seconds = 6.0;
    const Commands motion = make_motion(plan, limits);
    const JointLimits& joint = limits.joints[kElbow];
    double farthest = 0.0;
    for (size_t k = 0; motion.time[k] < 1.0; ++k)
      farthest = std::max(farthest, std::abs(motion.position[kElbow][k] - joint.start));
    EXPECT_LT(farthest, 0.2 * (joint.upper - joint.lower)) << get_family_word(plan.family);
  }
}

// Efforts limit the quick sines of a wrist; the slow ones may then be larger.
TEST(NextExperiment, SlowSinesReachAsFarWithAFractionOfTheAcceleration) {
  const Experiment e = simulate_arm("next_slow_sines", {});
  const Limits limits = make_limits(e, {});
  const std::vector<MotionPlan> plans = list_plans(e, limits, {1, 1}, 20.0);  // [s] little of it grows
  const auto measure = [&](double quickest) {  // largest travel [rad] and acceleration [rad/s^2] of the elbow
    const auto plan = std::find_if(plans.begin(), plans.end(), [&](const MotionPlan& p) {
      return p.family == Family::kMultisine && p.quickest == quickest;
    });
    const Commands motion = make_motion(*plan, limits);
    const std::vector<double>& q = motion.position[kElbow];
    const auto [low, high] = std::minmax_element(q.begin(), q.end());
    double most = 0.0;
    for (double a : calc_rates(motion.velocity[kElbow], plan->period)) most = std::max(most, std::abs(a));
    return std::pair{*high - *low, most};
  };
  const auto [slow_travel, slow_acceleration] = measure(kSlowSines);
  const auto [quick_travel, quick_acceleration] = measure(kQuickSines);
  EXPECT_GT(slow_travel, 0.8 * quick_travel);  // phases differ, so the sines do not add up at the same time
  EXPECT_LT(slow_acceleration,
            0.4 * quick_acceleration);  // the quickest sine: (1.2 / 3)^2, with sqrt(3 / 1.2) times its amplitude
}

// Share of the mean square that frequencies up to 0.6 Hz have.
double calc_slow_share(const std::vector<double>& x, double period) {
  const double n = static_cast<double>(x.size());
  double slow = 0.0, all = 0.0;
  for (double one : x) all += one * one / n;
  for (int bin = 1; bin <= static_cast<int>(0.6 * n * period); ++bin) {
    double c = 0.0, s = 0.0;
    for (size_t k = 0; k < x.size(); ++k) {
      const double phase = 2.0 * M_PI * bin * static_cast<double>(k) / n;
      c += x[k] * std::cos(phase) / n;
      s += x[k] * std::sin(phase) / n;
    }
    slow += 2.0 * (c * c + s * s);
  }
  return slow / all;
}

// Else what a quick neighbour does to a slow joint looks like an effect of the joint's own.
TEST(NextExperiment, SinesMoveEveryJointSlowlyAndFast) {
  const Limits limits = make_limits(simulate_arm("next_sines", {}), {});
  for (unsigned seed = 1; seed <= 40; ++seed) {
    MotionPlan plan;
    plan.moves = {1, 1};
    plan.seed = seed;
    plan.seconds = 6.0;
    const Commands motion = make_motion(plan, limits);
    for (size_t j = 0; j < 2; ++j) {
      EXPECT_LT(calc_slow_share(motion.velocity[j], plan.period), 0.9) << seed;
      EXPECT_GT(calc_slow_share(motion.position[j], plan.period), 0.1) << seed;
    }
  }
}

// The arm that is asked about, and two motions for it: one to fit values to, one held out.
const Experiment& get_poor_experiment() {
  static const Experiment e = make_poor_experiment("next_friction", kArm, make_viscous());
  return e;
}

const Next& get_two_motions() {
  static const Next next = [] {
    NextOptions options = make_options();
    options.count = 2;
    return propose(get_poor_experiment(), make_open_report(), options, kQuietly);
  }();
  return next;
}

TEST(NextExperiment, ViscousAgainstDryFrictionMovesAtTwoSpeedsAndExpectsADecision) {
  const Next& next = get_two_motions();
  ASSERT_EQ(next.proposals.size(), 2u) << next.nothing;
  const Proposal& p = next.proposals[0];
  const auto dry = std::find_if(p.expected.begin(), p.expected.end(),
                                [](const Expected& x) { return x.label == "coulomb_friction@elbow"; });
  ASSERT_NE(dry, p.expected.end());
  EXPECT_GT(dry->probability, 0.9);
  std::vector<double> speeds;
  for (double v : p.commands.velocity[kElbow]) speeds.push_back(std::abs(v));
  std::sort(speeds.begin(), speeds.end());
  // A quarter of the time slower than a half of the speed that a tenth of the time exceeds.
  EXPECT_LT(speeds[speeds.size() / 4], 0.5 * speeds[speeds.size() * 9 / 10]);
}

TEST(NextExperiment, NoMotionPassesAJointsLimitUnderAnyExplanation) {
  const Experiment& e = get_poor_experiment();
  NextOptions options = make_options();
  options.count = 2;
  options.limits = {"elbow.upper=0.25", "elbow.lower=-0.7", "speed=1", "shoulder.effort=30"};
  const Next next = propose(e, make_open_report(), options, kQuietly);
  ASSERT_FALSE(next.proposals.empty());
  Experiment bare = e;
  bare.recordings.clear();
  for (const Proposal& p : next.proposals) {
    const auto motion = make_trial_motion(bare, e.recordings[0], p.commands, {});
    for (const Hypothesis& h :
         {Hypothesis{}, make_viscous(), Hypothesis{{EffectId::kCoulomb, kElbow, {0.2, 0.0, 5e-4}}}}) {
      std::vector<double> y;
      ASSERT_TRUE(simulate_trial(*motion, h, &y));
      for (size_t k = motion->problem.smooth[0].start; k < p.commands.time.size(); ++k) {
        EXPECT_LE(y[k * 6 + 3], 0.25);
        EXPECT_GE(y[k * 6 + 3], -0.7);
        EXPECT_LE(std::abs(y[k * 6 + 4]), 1.0 / 0.9);
        EXPECT_LE(std::abs(y[k * 6 + 2]), 30.0);
      }
    }
  }
}

// The report fits values to the recordings for training.
TEST(NextExperiment, AHeldOutMotionNarrowsNoInterval) {
  const Next& next = get_two_motions();
  ASSERT_EQ(next.proposals.size(), 2u);
  ASSERT_FALSE(next.proposals[0].intervals.empty());
  for (size_t i = 0; i < next.proposals[0].intervals.size(); ++i) {
    EXPECT_LT(next.proposals[0].intervals[i].after, next.proposals[0].intervals[i].before);
    EXPECT_EQ(next.proposals[1].intervals[i].after, next.proposals[0].intervals[i].after);
  }
}

TEST(NextExperiment, AMotionThatNeedsMoreEffortThanAllowedIsNotProposed) {
  const Experiment& e = get_poor_experiment();
  NextOptions options = make_options();
  options.limits = {"shoulder.effort=5"};  // N m: its own weight takes 9.4
  const Next next = propose(e, make_open_report(), options, kQuietly);
  EXPECT_TRUE(next.proposals.empty());
  EXPECT_NE(next.nothing.find("No motion is safe"), std::string::npos) << next.nothing;
}

// Else one tight joint would shrink the motion of the whole arm.
TEST(NextExperiment, OnlyTheJointThatPassesItsOwnLimitMovesLess) {
  const Experiment e = simulate_arm("next_sizes", {});
  Limits limits = make_limits(e, {});
  MotionPlan plan;
  plan.moves = {1, 1};
  plan.seconds = 4.0;
  const Commands large = make_motion(plan, limits);
  limits.joints[0].effort = 1e3;
  limits.joints[kElbow].effort = 0.1;  // N m: less than its own weight takes
  Experiment bare = e;
  bare.recordings.clear();
  std::vector<char> faulty(2, 0);
  EXPECT_FALSE(
      Safety(e, limits).find_fault(*make_trial_motion(bare, e.recordings[0], large, {}), {}, nullptr, &faulty).empty());
  EXPECT_EQ(faulty, (std::vector<char>{0, 1}));
  ASSERT_TRUE(make_smaller(faulty, &plan));
  const Commands smaller = make_motion(plan, limits);
  EXPECT_EQ(smaller.position[0], large.position[0]);
  EXPECT_NE(smaller.position[kElbow], large.position[kElbow]);
  int steps = 1;
  while (make_smaller(faulty, &plan)) ++steps;
  EXPECT_LT(plan.size, kMinority) << "what the others do to it is looked at, too";
  EXPECT_LT(steps, 15) << "the number of simulations is bounded";
}

// Fitted to the recordings and the proposed motion as the robot then moves; the noise is drawn once.
TEST(NextExperiment, TheExpectedIntervalIsThatOfTheRepeatedExperiment) {
  Experiment e = get_poor_experiment();
  const Next& next = get_two_motions();
  ASSERT_EQ(next.proposals.size(), 2u);
  const Proposal& p = next.proposals[0];
  ASSERT_EQ(p.intervals.size(), 1u);
  Experiment bare = e;
  bare.recordings.clear();
  auto motion = make_trial_motion(bare, e.recordings[0], p.commands, make_viscous());
  TestNoise noise;
  const double sigma[] = {2e-5, 0.002, 0.02};
  Recording played = motion->experiment.recordings[0];
  for (size_t c = 0; c < 6; ++c) {
    for (double& x : played.joints[c / 3].signal[c % 3]) x += sigma[c % 3] * noise.draw();
  }
  e.recordings.push_back(played);
  const Problem problem = make_problem(e, 1);
  FitOptions options;
  options.intervals = true;
  const FitResult result = fit(problem, make_viscous(), {0, 1, 2, 3}, options);
  ASSERT_TRUE(result.ok);
  const double half = 1.96 * std::hypot(result.std[0][0], 1e-3);
  // Scatter of a sandwich covariance from 40 stretches a recording: some 15 %; the bar is a factor of 1.5.
  EXPECT_LT(half / p.intervals[0].after, 1.5);
  EXPECT_GT(half / p.intervals[0].after, 1.0 / 1.5);
  EXPECT_LT(p.intervals[0].after, p.intervals[0].before);
}

TEST(NextExperiment, WithoutAMismatchNothingIsProposed) {
  const Experiment e = simulate_arm("next_nothing", {});
  const Next next = propose(e, {{"verdict", "no_mismatch"}, {"findings", Json::array()}}, make_options(), kQuietly);
  EXPECT_TRUE(next.proposals.empty());
  EXPECT_NE(next.nothing.find("nothing is ambiguous"), std::string::npos) << next.nothing;
}

TEST(NextExperiment, WithoutPositionLimitsMotionsStayWithinWhatWasRecorded) {
  std::string urdf = kArm;
  const std::string limit =
      R"(<axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="50" velocity="10"/></joint></robot>)";
  urdf.replace(urdf.find(limit), limit.size(), R"(<axis xyz="0 1 0"/></joint></robot>)");
  urdf.replace(urdf.rfind("revolute"), 8, "continuous");
  const Experiment e = make_simulated_experiment("next_unlimited", urdf, kArmJoints, {});
  const Limits limits = make_limits(e, {});
  EXPECT_LE(limits.joints[kElbow].upper, 0.6);  // the commands' amplitude
  EXPECT_TRUE(std::any_of(limits.remarks.begin(), limits.remarks.end(),
                          [](const std::string& r) { return r.find("elbow has no position limits") == 0; }));
}

TEST(NextExperiment, ALimitThatCannotBeReadIsRefusedByName) {
  const Experiment e = simulate_arm("next_words", {});
  for (const char* word : {"speed", "speed=fast", "wrist.speed=1", "colour=3", "elbow.lower=0.5"}) {
    try {
      make_limits(e, {word});
      ADD_FAILURE() << word << " was taken";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("--limit"), std::string::npos);
    }
  }
}

TEST(NextExperiment, LimitsOnlyTighten) {
  const Experiment e = simulate_arm("next_tighten", {});
  const Limits usual = make_limits(e, {}), wide = make_limits(e, {"speed=1000", "effort=1000", "reach=50"});
  EXPECT_DOUBLE_EQ(wide.joints[0].speed, usual.joints[0].speed);
  EXPECT_DOUBLE_EQ(wide.joints[0].effort, usual.joints[0].effort);
  EXPECT_DOUBLE_EQ(wide.joints[0].hard_upper, usual.joints[0].hard_upper);
}

// The description ends at 3 rad, and commands keep a twentieth of the range from both ends.
TEST(NextExperiment, MotionsReachAsFarAsTheDescriptionOrWhatIsStated) {
  const Experiment e = simulate_arm("next_reach", {});
  const double start = make_limits(e, {}).joints[0].start;
  EXPECT_NEAR(make_limits(e, {}).joints[0].upper, 2.7, 1e-12);
  const JointLimits stated = make_limits(e, {"reach=2"}).joints[0];
  EXPECT_DOUBLE_EQ(stated.hard_upper, start + 2.0);
  EXPECT_NEAR(stated.upper, start + 2.0 - 0.05 * 3.8, 1e-12) << "a twentieth of -1.8 to 2 rad, later tightened alike";
  EXPECT_NEAR(make_limits(e, {"reach=50"}).joints[0].upper, 2.7, 1e-12);
  EXPECT_NEAR(make_limits(e, {"reach=50"}).joints[0].lower, -2.7, 1e-12);
  for (const auto& words : {std::vector<std::string>{"reach=50", "shoulder.upper=0.5"},
                            std::vector<std::string>{"shoulder.upper=0.5", "reach=50"}})
    EXPECT_LT(make_limits(e, words).joints[0].upper, 0.5);
  EXPECT_DOUBLE_EQ(make_limits(e, {"shoulder.reach=0.2", "reach=2"}).joints[0].upper,
                   make_limits(e, {"shoulder.reach=0.2"}).joints[0].upper);
}

// A person has to keep that space free: the tool knows nothing of what stands around.
TEST(NextExperiment, TheSpaceToKeepFreeIsThatOfTheCommands) {
  const Experiment e = simulate_arm("next_space", {});
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "hrp_next_space";
  Next next;
  Proposal p;
  p.file = "train_1.csv";
  p.plan.moves = {1, 0};
  p.plan.seconds = 4.0;
  p.moving = {"shoulder"};
  p.commands = make_motion(p.plan, make_limits(e, {}));
  next.proposals = {p};
  write_next(e, next, folder.string());
  const auto read = [&](const char* name) {
    std::ifstream in(folder / "next" / name);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  const Json ranges = Json::parse(read("next.json"))["motions"][0]["ranges"];
  ASSERT_EQ(ranges.size(), 1u) << "the elbow rests";
  for (double q : p.commands.position[kShoulder]) {
    EXPECT_GE(q, ranges["shoulder"][0].get<double>() - 5e-4);
    EXPECT_LE(q, ranges["shoulder"][1].get<double>() + 5e-4);
  }
  EXPECT_GT(ranges["shoulder"][1].get<double>() - ranges["shoulder"][0].get<double>(), 2.0)
      << "more than 1 rad either way";
  EXPECT_NE(read("next.html").find("Keep this space free. Joints move over [rad or m]: shoulder"), std::string::npos);
}

}  // namespace
}  // namespace hrp::diagnosis
