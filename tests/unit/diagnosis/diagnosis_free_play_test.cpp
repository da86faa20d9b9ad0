// SPDX-License-Identifier: BSD-3-Clause
// Standing robots: links between loose teeth, noise that a hypothesis adds by itself, links that move alike, couplings,
// soles.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "diagnosis/estimate/slopes.h"
#include "diagnosis/standing/channels.h"
#include "diagnosis/standing/dependence.h"
#include "diagnosis/standing/free_play.h"
#include "diagnosis/standing/judge.h"
#include "diagnosis/standing/layout.h"
#include "diagnosis/standing/sole.h"

namespace hrp::diagnosis::standing {
namespace {

TEST(LooseTeeth, LieOnASideOnlyWhereATorqueAboveTheNoiseLasts) {
  const std::vector<double> torque{0.1, 2, 2, 2, 0.2, 3, -3, -3, -3};
  EXPECT_EQ(find_sides(torque, 1.0), (std::vector<int>{0, 0, 1, 0, 0, 0, 0, -1, -1}));
}

// A link that swings freely within a gap of 0.01 rad and is stopped at its ends, seen by a tilt and by a place that is
// known but for a constant.
struct Swing {
  std::vector<double> truth, middle, aside;
  static constexpr double kGap = 0.01, kLever = 0.6;  // [rad], [m]
  Swing() {
    std::mt19937 random(5);
    std::normal_distribution<double> noise;
    for (int k = 0; k < 200; ++k) {
      const double offset = std::clamp(0.008 * std::sin(0.1 * k), -kGap / 2, kGap / 2);
      const double tilt = offset + 6e-5 * noise(random), place = 0.2 + kLever * offset + 1e-5 * noise(random);
      truth.push_back(offset);
      middle.insert(middle.end(), {tilt, place});
      aside.insert(aside.end(), {tilt - kSlopeStep, place - kLever * kSlopeStep});
    }
  }
};

TEST(LooseTeeth, AreFoundWhereTheFeetSayThoughNoTorqueHoldsThem) {
  const Swing swing;
  const std::vector<int> free(swing.truth.size(), 0);
  const std::vector<double> found =
      place_within_play({swing.middle, swing.aside, 2, 2, 1}, {6e-5, 1e-5}, free, Swing::kGap);
  // The place tells 1e-5 / 0.6 rad, the tilts' mean what is constant: 6e-5 / sqrt(200); six deviations of both.
  for (size_t k = 0; k < found.size(); ++k) EXPECT_NEAR(found[k], swing.truth[k], 1.3e-4) << k;
}

TEST(LooseTeeth, OfTooSmallAGapLeaveWhatTheLinkMovesBeyondIt) {
  const Swing swing;
  const std::vector<int> free(swing.truth.size(), 0);
  const std::vector<double> found = place_within_play({swing.middle, swing.aside, 2, 2, 1}, {6e-5, 1e-5}, free, 0.004);
  for (double offset : found) EXPECT_LE(std::abs(offset), 0.002);
  EXPECT_GT(std::abs(swing.truth[16] - found[16]), 0.002);
}

// A trunk that rocks by 0.02 rad on an ankle whose encoder does not move, over one flat foot that feels `moment`.
struct LooseAnkle {
  Experiment experiment;
  StandProblem p;
  explicit LooseAnkle(double moment) {
    LinkSpec trunk, foot;
    trunk.name = "trunk";
    trunk.inertia.mass = 12;
    trunk.inertia.I_LLcm_L = Matrix3d::Identity();
    foot.name = "foot";
    foot.parent = 0;
    foot.joint.name = "ankle";
    foot.joint.axis_F = Vector3d::UnitY();
    foot.inertia.mass = 1e-9;
    foot.inertia.I_LLcm_L = 1e-12 * Matrix3d::Identity();
    p.experiment = &experiment;
    p.tree.links = {trunk, foot};
    p.imu_link = 0;
    p.feet.push_back({"foot", "foot_ft", 1});
    p.effort = p.command = p.velocity = {false};
    p.slack = {0.1};
    p.recordings.push_back(rock(moment));
    p.noise.assign(list_channels(p).size(), 1e-4);
  }

  static StandRecording rock(double moment) {
    StandRecording r;
    const auto constant = [](double value) {
      return SmoothSeries{std::vector<double>(200, value), std::vector<double>(200, 0.0),
                          std::vector<double>(200, 0.0)};
    };
    r.position = {constant(0)};
    r.velocity = r.effort = r.command = {SmoothSeries{}};
    for (int i = 0; i < 3; ++i) {
      r.gyro[i] = constant(0);
      r.accelerometer[i] = constant(i == 2 ? 9.81 : 0);
    }
    for (SmoothSeries& s : r.attitude) s = constant(0);
    for (int i = 0; i < 6; ++i) r.wrench.push_back(constant(i == 2 ? 12 * 9.81 : i == 4 ? moment : 0));
    for (int k = 0; k < 200; ++k) {
      const auto i = static_cast<size_t>(k);
      const double half = 0.5 * 0.02 * std::sin(0.1 * k);
      r.time.push_back(0.03 * k);
      r.samples.push_back(k);
      r.attitude[0].value[i] = std::cos(half);
      r.attitude[2].value[i] = std::sin(half);
    }
    return r;
  }
};

// What was seen is the least that the gap can be: in other recordings the link may go further.
TEST(LooseTeeth, ThatNoTorqueEverHeldMayBeAnyDistanceApart) {
  const LooseAnkle free(0);
  Effect gap{EffectId::kBacklash, at_joint(0), {0.01, 0, 0, 0}};
  find_seen_play(free.p, {gap}, &gap);
  EXPECT_NEAR(gap.p[3], 0.04, 1e-3);
  const std::vector<double> left = calc_channels(free.p, {gap}, 0);
  for (size_t k = 0; k < left.size(); k += list_channels(free.p).size()) EXPECT_NEAR(left[k + 1], 0, 1e-4) << k;
}

TEST(LooseTeeth, ThatATorqueHeldAreAsFarApartAsItSays) {
  const LooseAnkle held(0.5);
  Effect gap{EffectId::kBacklash, at_joint(0), {0.01, 0, 0, 0}};
  find_seen_play(held.p, {gap}, &gap);
  EXPECT_EQ(gap.p[0], 0.01);
}

TEST(LooseTeeth, LookLikeAnOffsetWhereATorqueHoldsThemOnItsSideAllTheTime) {
  StandProblem p;
  p.effort = {true};
  p.slack = {0.5};
  const auto may_be = [&](const std::vector<double>& torques, double offset) {
    StandBase base;
    for (double torque : torques) base.states.push_back({0, 0, 0, 0, torque});
    return may_be_play(p, {base}, 0, offset);
  };
  EXPECT_TRUE(may_be({2, 3, 2}, 0.01));
  EXPECT_FALSE(may_be({2, 3, 2}, -0.01)) << "they give way to the torque";
  EXPECT_FALSE(may_be({2, 3, 2, -2, -3, -2}, 0.01)) << "the link would have gone to the other side";
  EXPECT_FALSE(may_be({0.1, 0.2, 0.1}, 0.01)) << "nothing held it";
}

// The attitude turns by up to 0.02 rad x 0.1 / 0.03 s; the gyroscope says nothing.
TEST(StandingChannels, OfThinnedOutSamplesStillHoldTheGyroscopeAgainstTheAttitude) {
  const LooseAnkle robot(0);
  for (const StandProblem& p : {robot.p, make_coarse(robot.p)}) {
    const std::vector<double> rows = calc_channels(p, {}, 0);
    const size_t channels = list_channels(p).size();
    double most = 0;
    for (size_t k = channels - 5; k < rows.size(); k += channels) most = std::max(most, std::abs(rows[k]));
    EXPECT_NEAR(most, 0.067, 0.007);  // of a mean over 0.3 s sin(0.5) / 0.5 = 0.96 is left, and it need not be a crest
  }
}

// A clock that loses 5 % of 6 s shows the last 0.3 s of them after the recording's end.
TEST(StandingChannels, SayNothingWhereAWrongClocksReadingIsNotInTheRecording) {
  const LooseAnkle robot(0.5);
  const size_t channels = list_channels(robot.p).size(), torque = find_places(robot.p) + 1;
  const std::vector<double> slow =
      calc_channels(robot.p, {{EffectId::kClockSkew, at_sensor(0, Reading::kWrench), {-0.05}}}, 0);
  const std::vector<double> right = calc_channels(robot.p, {}, 0);
  for (size_t k = 0; k < 200; ++k) EXPECT_EQ(slow[k * channels + torque] == 0, k >= 190) << k;
  for (size_t k = 0; k < 200; ++k) EXPECT_NE(right[k * channels + torque], 0);
}

// A foot that stood on its edge for a third of a second, a tenth of a millimetre further forward since.
TEST(StandingChannels, DoNotMissAFootWhereItStoodBeforeItStoodOnItsEdge) {
  LooseAnkle robot(0);
  StandProblem& p = robot.p;
  StandRecording& r = p.recordings[0];
  p.base_pose = true;
  p.feet[0].size = {0.2, 0.1, 0.02};
  for (size_t i = 0; i < 4; ++i) {
    r.base_attitude[i] = r.attitude[i];
    if (i < 3) r.base_position[i] = r.gyro[i];  // zeros
  }
  const size_t channels = list_channels(p).size(), stand = find_places(p);
  const auto find_most = [&] {
    const std::vector<double> rows = calc_channels(p, {}, 0);
    double most = 0;
    for (size_t k = stand; k < rows.size(); k += channels) most = std::max(most, std::abs(rows[k]));
    return most;
  };
  for (size_t k = 100; k < 200; ++k) r.base_position[0].value[k] = 1e-4;
  EXPECT_NEAR(find_most(), 5e-5, 1e-6) << "half of it to both sides of its mean";
  for (size_t k = 95; k < 105; ++k) r.wrench[4].value[k] = 0.095 * 12 * 9.81;
  EXPECT_NEAR(find_most(), 0, 1e-9);
}

// A trunk on one ball foot, nothing recorded of the joint: six equations of balance, gyroscope, gravity.
StandProblem make_block() {
  StandProblem p;
  p.imu = "imu";
  p.feet.push_back({"foot", "foot_ft", 1});
  p.feet[0].kind = SoleKind::kBall;
  LinkSpec trunk, foot;
  trunk.name = "trunk";
  trunk.inertia.mass = 12;
  foot.name = "foot";
  foot.inertia.mass = 3;
  p.tree.links = {trunk, foot};
  p.effort = p.command = p.velocity = {false};
  p.recordings.resize(2);
  p.recordings[1].train = false;
  return p;
}

// White noise of a channel in even, odd and all samples.
struct Halves {
  Evaluation all, even, odd;
  Halves(const StandProblem& p, double noise) : all(2), even(2), odd(2) {
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    const size_t channels = list_channels(p).size();
    for (size_t r = 0; r < 2; ++r) {
      for (int k = 0; k < 400; ++k) {
        for (size_t c = 0; c < channels; ++c) {
          const double size = c == 5 ? noise : 1.0, a = size * normal(random), b = size * normal(random);
          even[r].residuals.push_back(a);
          odd[r].residuals.push_back(b);
          all[r].residuals.push_back(0.5 * (a + b));
        }
      }
    }
  }
};

// A mass of 1.4 times the model's makes the vertical force's noise larger where the acceleration is noisy.
TEST(StandingJudge, DoesNotCountTheNoiseThatAHypothesisAdds) {
  const StandProblem p = make_block();
  const Halves before(p, 1.0), after(p, 1.4);
  StandJudge judge(p);
  judge.update_sigma(before.all, {before.even, before.odd, before.even, before.odd}, {});
  const double score = judge.judge({}, before.all).score, blind = judge.judge({}, after.all).score;
  const double told = judge.judge({}, after.all, judge.find_extra_noise(after.even, after.odd)).score;
  EXPECT_GT(blind - score, 300);  // 800 samples x ln(1.4^2) = 538, less what stays below sigma
  // Scatter of the difference of two mean squares of 800 samples: 10 %.
  EXPECT_LT(std::abs(told - score), 100);
}

TEST(StandingEffects, OfLinksThatMoveAlikeTheHeavyOneIsBelievedToCarryTheLoad) {
  const StandProblem p = make_block();
  const Effect trunk{EffectId::kPayload, at_link(0), {1, 0, 0, 0}}, foot{EffectId::kPayload, at_link(1), {1, 0, 0, 0}};
  EXPECT_EQ(find_doubt(p, trunk), 0);
  EXPECT_NEAR(find_doubt(p, foot), std::log(4), 1e-12);  // 12 kg, 3 kg
  EXPECT_EQ(find_doubt(p, {EffectId::kViscous, at_joint(0), {1}}), 0);
}

// Pulls come from anywhere; one that is plumb is more likely a weight.
TEST(StandingEffects, APlumbForceIsDoubtedASlantedOneIsNot) {
  const StandProblem p = make_block();
  EXPECT_GT(find_doubt(p, {EffectId::kExternalForce, at_link(0), {0.02, 0, -15}}), 8);  // ln(2 / 0.02^2) = 8.5
  EXPECT_LT(find_doubt(p, {EffectId::kExternalForce, at_link(0), {30, 20, -15}}), 2);
}

TEST(StandingDependence, OfTwoCoupledJointsIsSeenInTheOneThatLacksTheOthersPull) {
  StandProblem p;
  LinkSpec link;
  for (const char* name : {"base", "hip", "knee"}) {
    link.name = name;
    p.tree.links.push_back(link);
  }
  p.tree.links[1].parent = 0;
  p.tree.links[2].parent = 1;
  p.tree.links[1].joint.name = "hip";
  p.tree.links[2].joint.name = "knee";
  p.recordings.resize(1);
  Evaluation coupled(1), own(1);
  for (int k = 0; k < 300; ++k) {
    p.recordings[0].samples.push_back(k);
    const double hip = std::sin(0.05 * k), knee = std::cos(0.083 * k);
    coupled[0].residuals.push_back(2 * (hip - knee));
    own[0].residuals.push_back(2 * hip);
    p.recordings[0].position.resize(2);
    p.recordings[0].position[0].value.push_back(hip);
    p.recordings[0].position[1].value.push_back(knee);
  }
  const Channel channel{ChannelKind::kEffort, "", "hip", "", "", ""};
  EXPECT_TRUE(follows_joint(p, channel, 0, coupled, 1));
  EXPECT_FALSE(follows_joint(p, channel, 0, own, 1));
}

CollisionShape make_sphere(int link, double x, double y, double radius) {
  CollisionShape shape;
  shape.link = link;
  shape.kind = ShapeKind::kSphere;
  shape.size.x() = radius;
  shape.X_LG.p = {x, y, -0.03};
  return shape;
}

// Four small spheres under the corners of a foot, as some makers describe soles, are no ball that rolls.
TEST(StandingFeet, OnSpheresUnderTheCornersOfASoleStandFlat) {
  RobotDescription robot;
  for (const double x : {-0.05, 0.12}) {
    for (const double y : {-0.03, 0.03}) robot.shapes.push_back(make_sphere(3, x, y, 0.005));
  }
  StandFoot foot;
  foot.link = 3;
  read_sole(robot, &foot);
  EXPECT_EQ(foot.kind, SoleKind::kFlat);
  EXPECT_NEAR(foot.size.x(), 0.17, 1e-12);
  EXPECT_NEAR(foot.size.y(), 0.06, 1e-12);
  EXPECT_NEAR((foot.sole - Vector3d(0.035, 0, -0.035)).norm(), 0, 1e-12);
}

TEST(StandingFeet, OnOneSphereRoll) {
  RobotDescription robot;
  robot.shapes.push_back(make_sphere(3, 0, 0, 0.02));
  StandFoot foot;
  foot.link = 3;
  read_sole(robot, &foot);
  EXPECT_EQ(foot.kind, SoleKind::kBall);
  EXPECT_EQ(foot.radius, 0.02);
}

TEST(StandingDependence, OfAPullBetweenTwoDrivesIsEqualAndOppositeMissingEfforts) {
  Evaluation pull(1), alike(1);
  for (int k = 0; k < 300; ++k) {
    const double x = std::sin(0.05 * k);
    pull[0].residuals.insert(pull[0].residuals.end(), {x, -1.05 * x});
    alike[0].residuals.insert(alike[0].residuals.end(), {x, x});
  }
  EXPECT_TRUE(are_equal(pull, 2, 0, 1, -1));
  EXPECT_FALSE(are_equal(alike, 2, 0, 1, -1));
  EXPECT_TRUE(are_equal(alike, 2, 0, 1, 1)) << "a spring on the sum of two positions pulls both the same way";
}

}  // namespace
}  // namespace hrp::diagnosis::standing
