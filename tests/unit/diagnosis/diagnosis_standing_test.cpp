// SPDX-License-Identifier: BSD-3-Clause
// Standing robots: what the smoothing, the hints, the intervals and the dependence finder claim.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "diagnosis/data/smooth.h"
#include "diagnosis/standing/dependence.h"
#include "diagnosis/standing/findings.h"
#include "diagnosis/standing/hints.h"
#include "diagnosis/standing/judge.h"
#include "diagnosis/standing/slip.h"

namespace hrp::diagnosis::standing {
namespace {

std::vector<double> make_uneven_times(int count) {
  std::vector<double> time;
  for (int k = 0; k < count; ++k) time.push_back(0.004 * k + 0.001 * std::sin(7.0 * k));
  return time;
}

TEST(StandingSmoothing, KeepsACubicWithItsDerivativesOnUnevenStampsFromAnyHalfOfTheSamples) {
  const std::vector<double> time = make_uneven_times(100);
  std::vector<double> values;
  for (double t : time) values.push_back(1 + 2 * t - 3 * t * t + 5 * t * t * t);
  for (Parity parity : {Parity::kAll, Parity::kEven, Parity::kOdd}) {
    const SmoothSeries s = Smoother(time, 8, parity).run(values);
    const double t = time[50];
    // Rounding: the normal matrix of a cubic has a condition of about 1e3, with a ridge of 1e-12.
    EXPECT_NEAR(s.value[50], values[50], 1e-9);
    EXPECT_NEAR(s.rate[50], 2 - 6 * t + 15 * t * t, 1e-6);
    EXPECT_NEAR(s.second[50], -6 + 30 * t, 1e-4);
  }
}

// What makes a fit of even against odd samples free of the bias by noise: their errors have nothing in common.
TEST(StandingSmoothing, GivesEvenAndOddSamplesIndependentErrors) {
  const std::vector<double> time = make_uneven_times(20000);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::vector<double> noise;
  for (size_t k = 0; k < time.size(); ++k) noise.push_back(normal(random));
  const SmoothSeries even = Smoother(time, 8, Parity::kEven).run(noise),
                     odd = Smoother(time, 8, Parity::kOdd).run(noise);
  double ee = 0, eo = 0;
  for (size_t k = 0; k < time.size(); ++k) {
    ee += even.value[k] * even.value[k];
    eo += even.value[k] * odd.value[k];
  }
  // 20000 samples over windows of 17: about 1200 independent errors, whose mean product scatters by 0.03.
  EXPECT_LT(std::abs(eo / ee), 0.12);
}

// A standing robot's problem with one driven joint and no feet: enough for what works on columns alone.
StandProblem make_columns(int recordings) {
  StandProblem p;
  p.effort = {true};
  p.command = {false};
  p.velocity = {false};
  for (int r = 0; r < recordings; ++r) {
    StandRecording recording;
    recording.train = r == 0;
    for (int k = 0; k < 600; ++k) {
      recording.time.push_back(0.015 * k);
      recording.samples.push_back(k);
    }
    SmoothSeries q, load;
    for (double t : recording.time) {
      const double w = 1.1 + 0.3 * r;
      q.value.push_back(0.5 * std::sin(w * t));
      q.rate.push_back(0.5 * w * std::cos(w * t));
      q.second.push_back(0);
    }
    load.value.assign(recording.time.size(), 100.0);
    recording.position.push_back(q);
    recording.effort.push_back({});
    recording.wrench.assign(6, load);
    p.recordings.push_back(recording);
  }
  return p;
}

// One channel: the effort that is missing as a function of position and velocity, with noise.
template <class Missing>
Evaluation evaluate_missing(const StandProblem& p, Missing missing) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 0.01);
  Evaluation out;
  for (const StandRecording& r : p.recordings) {
    StandBase base;
    for (size_t k = 0; k < r.time.size(); ++k) {
      const double q = r.position[0].value[k], v = r.position[0].rate[k];
      base.states.push_back({q, q, v, -q, 0});
      base.residuals.push_back(missing(q, v) + noise(random));
    }
    out.push_back(base);
  }
  return out;
}

TEST(StandingHints, FindARipplesPeriodsBesideFrictionAndASpring) {
  StandProblem p = make_columns(2);
  // There are no feet: with a base pose the channels of places and balance come first, as they do on a robot.
  p.base_pose = true;
  p.attitude = false;
  const size_t first = find_drives(p);
  Evaluation left = evaluate_missing(
      p, [](double q, double v) { return 0.3 * std::sin(23 * q + 0.4) + 2 * q + (v > 0 ? 0.8 : -0.8) + 0.5 * v; });
  for (StandBase& base : left) {  // the channels before the drives' say nothing
    std::vector<double> rows;
    for (double e : base.residuals) {
      rows.insert(rows.end(), first, 0.0);
      rows.push_back(e);
    }
    base.residuals = rows;
  }
  const std::vector<double> found = find_ripples(p, left)[0];
  ASSERT_FALSE(found.empty());
  EXPECT_NEAR(found[0], 23, 2 * M_PI / 1.0 / 2);  // half a period over the range of 1 rad: what a fit starts from
}

TEST(StandingDependence, OfARemainderThatFollowsTimeIsNamedTime) {
  StandProblem p = make_columns(2);
  Evaluation left(2);
  for (size_t r = 0; r < 2; ++r) {
    for (double t : p.recordings[r].time) left[r].residuals.push_back(0.3 * std::sin(2 * M_PI * 4.3 * t + 1.0 + r));
  }
  const Relation found = find_dependence(p, {ChannelKind::kTilt, "", "", "foot", "", ""}, 0, left);
  EXPECT_EQ(found.names, std::vector<std::string>{"time"});
  EXPECT_NE(found.words.find("4.3 times a second"), std::string::npos) << found.words;
}

TEST(StandingDependence, OfNoiseIsNothing) {
  StandProblem p = make_columns(2);
  const Evaluation left = evaluate_missing(p, [](double, double) { return 0.0; });
  EXPECT_TRUE(find_dependence(p, {ChannelKind::kTilt, "", "", "foot", "", ""}, 0, left).names.empty());
}

// What a robot's equations leave by even and odd samples, then with wider windows: noise of a standard deviation of 1
// of its own in each half, and 20 sin(2 pi 8 Hz t), of which wide windows take a share more.
std::array<Evaluation, 4> make_disturbed_halves(size_t channels, double taken) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  std::array<Evaluation, 4> out;
  for (Evaluation& e : out) e.resize(1);
  for (size_t k = 0; k < 400; ++k) {
    const double fast = 20 * std::sin(2 * M_PI * 8 * 0.03 * static_cast<double>(k));
    for (size_t c = 0; c < channels; ++c) {
      for (size_t half = 0; half < 2; ++half) {
        const double noise = normal(random);
        out[half][0].residuals.push_back(fast + noise);
        out[half + 2][0].residuals.push_back((1 - taken) * fast + noise);
      }
    }
  }
  return out;
}

double find_sigma(double taken, bool held) {
  StandProblem p;
  p.feet.resize(1);
  p.tree.links.resize(1);
  p.held = held;
  StandRecording recording;
  p.recordings.push_back(recording);
  StandJudge judge(p);
  const std::array<Evaluation, 4> halves = make_disturbed_halves(judge.list().size(), taken);
  Evaluation all = halves[0];
  for (size_t k = 0; k < all[0].residuals.size(); ++k) {
    all[0].residuals[k] = 0.5 * (halves[0][0].residuals[k] + halves[1][0].residuals[k]);
  }
  judge.update_sigma(all, halves, {});
  return judge.sigma()[2];  // of a balance, whose least noise is far below
}

// The mean of two halves with noise of 1 has one of 0.71. 400 samples tell it to 4 %, four deviations are 15 %.
TEST(StandingNoise, OfADriveThatIsDisturbedFastIsNoDisturbance) {
  EXPECT_NEAR(find_sigma(0, false), 0.71, 0.1);
  EXPECT_GT(find_sigma(0, true), 5) << "held samples: third differences, which a fast disturbance enlarges";
}

// A tenth of 20 / sqrt(2) = 14: twice 1.4, beside the noise of 0.71, is 2.9.
TEST(StandingNoise, HoldsWhatSmoothingTakesAwayFromFastMotion) { EXPECT_NEAR(find_sigma(0.1, false), 2.9, 0.3); }

StandProblem make_soles(double length, double width) {
  StandProblem p;
  p.feet.resize(2);
  for (StandFoot& foot : p.feet) foot.size = {length, width, 0.02};
  return p;
}

// A bush of 1000 N m/rad on ground that gives 5e4 N m/rad seems to have 980; on ground that does not give, 1000.
TEST(StandingIntervals, OfAStiffnessHoldItWhateverTheGroundGives) {
  const StandProblem p = make_soles(0.22, 0.22);
  Eigen::VectorXd std = Eigen::VectorXd::Zero(2 * static_cast<long>(kFootParameters));
  for (const double ground : {5e4, 1e5, 1e9}) {
    Effect e{EffectId::kFootCompliance,
             {PlaceKind::kFoot, 0, Reading::kAll},
             std::vector<double>(2 * kFootParameters, 1e-6)};
    for (size_t f = 0; f < 2; ++f) e.p[f * kFootParameters] = e.p[f * kFootParameters + 2] = 1 / 1000.0 + 1 / ground;
    const Json k = make_estimates(make_parameters(p, e, std, 0))["k_pitch"];
    EXPECT_LE(k["ci95"][0].get<double>(), 1000) << ground;
    EXPECT_GE(k["ci95"][1].get<double>(), 1000) << ground;
    EXPECT_LT(k["ci95"][1].get<double>() - k["ci95"][0].get<double>(), 50) << ground;  // and stay of use: 5 %
  }
}

// Tables of Student's t for 95 and 99.9 %.
TEST(StandingIntervals, AreWiderWhereFewStretchesTellTheDeviation) {
  EXPECT_NEAR(find_student(1.960, 4), 2.776, 0.03);
  EXPECT_NEAR(find_student(1.960, 20), 2.086, 0.01);
  EXPECT_NEAR(find_student(3.291, 10), 4.587, 0.03);
  EXPECT_NEAR(find_student(1.960, 1e4), 1.960, 1e-3);
}

// The same ground gives more about the long edge of a sole: its lever is shorter.
TEST(StandingIntervals, AreWiderAboutTheLongEdgeOfASole) {
  const StandFoot foot = make_soles(0.24, 0.12).feet[0];
  EXPECT_DOUBLE_EQ(find_give(foot, 1), 2e-5);
  EXPECT_DOUBLE_EQ(find_give(foot, 0), 4 * 2e-5);
}

TEST(StandingEffects, ACentreOfMassOutsideItsLinkIsNotBelieved) {
  StandProblem p;
  LinkSpec link;
  link.inertia.mass = 0.5;
  p.tree.links.push_back(link);
  EXPECT_TRUE(is_sensible(p, {EffectId::kComError, at_link(0), {0.05, 0, 0.02}}));
  EXPECT_FALSE(is_sensible(p, {EffectId::kComError, at_link(0), {0, 0, 0.6}}));
}

// Of a joint that friction holds all the time the drive seems to give nothing.
TEST(StandingEffects, ALimitBelowTheNoiseOfTheTorqueThatItLimitsIsNotBelieved) {
  StandProblem p = make_columns(1);
  p.feet.resize(1);
  p.noise.assign(find_drive(p, 0) + 1, 0.3);
  EXPECT_FALSE(is_sensible(p, {EffectId::kSaturation, at_joint(0), {0.25}}));
  EXPECT_TRUE(is_sensible(p, {EffectId::kSaturation, at_joint(0), {2.0}}));
}

// Two joints with positions of their own or alike, and efforts that follow them: [joint a, joint b] a sample.
double find_spring_gain(bool alike, double own, double across) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.01);
  StandProblem p = make_columns(1);
  StandRecording& r = p.recordings[0];
  r.position.push_back(r.position[0]);
  for (size_t k = 0; k < r.time.size() && !alike; ++k) r.position[1].value[k] = 0.4 * std::cos(1.7 * r.time[k]);
  Evaluation left(1);
  for (size_t k = 0; k < r.time.size(); ++k) {
    const double a = r.position[0].value[k], b = r.position[1].value[k];
    for (const double q : {a, b}) left[0].residuals.push_back(own * q + across * (a + b) + noise(random));
  }
  return calc_spring_gain(p, left, {{0, 1}, {0, 1}, {0.01, 0.01}});
}

TEST(StandingDependence, OneSpringAcrossTwoJointsIsToldFromASpringInEachWhereTheyMoveApart) {
  EXPECT_GT(find_spring_gain(false, 3, 0), 1000) << "two springs";
  EXPECT_LT(find_spring_gain(false, 0, 3), 0) << "one across both";
  EXPECT_LT(find_spring_gain(true, 3, 0), 24) << "joints that move alike do not tell";
}

TEST(StandingFeet, ThatCreepAllThroughARecordingDoNotPassForNoise) {
  const std::vector<double> stands(100, 3e-5);
  std::vector<double> creeps(100, 2e-4);
  creeps[7] = -1;  // on an edge: not known
  EXPECT_EQ(find_rest({creeps, stands, {1e-6, -1, 1e-6}}), 3e-5) << "three samples are too few to tell";
}

// Two bodies that turn against each other about the vertical slip without any force along the ground.
TEST(StandingFeet, AskForFrictionWhereTheyAreTurnedToo) {
  StandFoot foot;
  foot.sole = {0.03, 0, -0.05};
  foot.size = {0.2, 0.1, 0};
  double lever = 0;  // [m] of a sole that presses evenly: mean distance of its points from its middle
  for (int i = 0; i < 10000; ++i) {
    const int row = i / 100;
    lever += 1e-4 * std::hypot(0.2 * ((i % 100 + 0.5) / 100 - 0.5), 0.1 * ((row + 0.5) / 100 - 0.5));
  }
  const auto ask = [&](const Vector3d& push, const Vector3d& at, double turn) {
    const Vector3d force = push + Vector3d(0, 0, 200);
    return find_asked_friction(foot, force, at.cross(force) + Vector3d(0, 0, turn), 200);
  };
  EXPECT_NEAR(ask({60, -80, 0}, foot.sole, 0), 0.5, 1e-9);
  EXPECT_NEAR(ask({60, -80, 0}, foot.sole + Vector3d(0.06, -0.02, 0), 0), 0.5, 1e-9) << "a push off the middle";
  EXPECT_NEAR(ask({0, 0, 0}, foot.sole, 200 * 0.5 * lever), 0.5, 1e-4);
  EXPECT_NEAR(ask({60, -80, 0}, foot.sole, 200 * 0.5 * lever), std::sqrt(0.5), 1e-4);
}

// What an even friction of 0.8 leaves of one whose level falls off where the joint is away from 0, or does not.
double find_uneven_gain(double fall) {
  const StandProblem p = make_columns(2);
  const Evaluation left = evaluate_missing(p, [&](double q, double v) { return (v > 0 ? -fall : fall) * q * q; });
  return calc_uneven_gain(p, left, 0, 0);
}

TEST(StandingDependence, OfFrictionThatFollowsThePositionIsSeenInWhatAnEvenFrictionLeaves) {
  EXPECT_GT(find_uneven_gain(0.3), 300);
  EXPECT_LT(find_uneven_gain(0), 24) << "an even friction leaves noise";
}

// Of a leg's transmissions what the ground may give about the same axis is not theirs; an arm's are all their own.
TEST(StandingEffects, OfALegsTransmissionWhatTheGroundMayGiveIsNotSure) {
  StandProblem p = make_soles(0.24, 0.12);
  p.tree.links.resize(4);  // trunk, shank, foot; arm
  p.tree.links[1].parent = 0;
  p.tree.links[2].parent = 1;
  p.tree.links[3].parent = 0;
  p.tree.links[1].joint.axis_F = Vector3d::UnitY();
  p.tree.links[2].joint.axis_F = Vector3d::UnitX();
  for (StandFoot& foot : p.feet) foot.link = 2;
  const auto find = [&](int joint) { return find_bound(p, {EffectId::kElasticity, at_joint(joint), {1e-3, 0.1}}, 0); };
  EXPECT_DOUBLE_EQ(find(0), 2e-5) << "pitch: 5e4 N m/rad about the short edge";
  EXPECT_DOUBLE_EQ(find(1), 4 * 2e-5) << "roll: about the long one, half as far away";
  EXPECT_EQ(find(2), 0) << "an arm";
}

}  // namespace
}  // namespace hrp::diagnosis::standing
