// SPDX-License-Identifier: BSD-3-Clause
// What single signals tell: tracks, landings, checks on whole recordings, the load share.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>
#include <string>
#include <utility>

#include "diagnosis/floating/checks/checks.h"
#include "diagnosis/floating/checks/landings.h"
#include "diagnosis/floating/checks/load_share.h"
#include "diagnosis/floating/diagnose.h"
#include "diagnosis/floating/log/correct_log.h"
#include "diagnosis/floating/log/tracks.h"
#include "servers/model_parser/robot_loader.h"
#include "tests/unit/diagnosis/legged/biped.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr Recorded kLeansWithImu{.leans = true};
const std::string kLeftHip = "0 0.1 0", kRightHip = "0 -0.1 0";

// Share of the time in which a foot without a force sensor counts as standing.
double find_standing(const LeggedLog& log, size_t foot) {
  const std::vector<char> loaded = find_contacts(log).loaded[0][foot];
  return static_cast<double>(std::count(loaded.begin(), loaded.end(), 1)) / static_cast<double>(loaded.size());
}

// Of the right foot, 0.6 m from the left one, on a hip that the model has `higher` [m] than it is.
double find_standing_if_raised(double higher) {
  Experiment e = make_biped({}, kLeansWithImu);
  std::string urdf = make_biped_urdf();
  for (const auto& [from, to] :
       {std::pair<std::string, std::string>{kLeftHip, "0 0.3 0"}, {kRightHip, "0 -0.3 " + std::to_string(higher)}})
    urdf.replace(urdf.find(from), from.size(), to);
  e.scenario.sensors.wrenches.clear();
  e.robot = parse_robot(urdf, "biped.urdf", e.scenario);
  return find_standing(make_legged_log(e, Half::kEven), 1);
}

TEST(LeggedContacts, AFootThatAnAttitudeAskewRaisesAllTheTimeStands) {
  EXPECT_DOUBLE_EQ(find_standing_if_raised(0.02), 1);  // 2 degrees across 0.6 m
  EXPECT_DOUBLE_EQ(find_standing_if_raised(0.06), 0);  // 6 degrees: held up
}

// Where nobody says which links are feet, the ground's force is in the torques of every leg, and no fault of a joint.
TEST(LeggedContacts, EndsOfLimbsMayStandWhereNoFeetAreTold) {
  Experiment e = make_biped({}, kLeansWithImu);
  e.scenario.sensors.wrenches.clear();
  e.scenario.feet.clear();
  const LeggedLog log = make_legged_log(e, Half::kEven);
  ASSERT_EQ(log.feet.size(), 2u);
  EXPECT_DOUBLE_EQ(find_standing(log, 0), 1);
  EXPECT_TRUE(std::any_of(log.missing.begin(), log.missing.end(),
                          [](const std::string& m) { return m.find("'feet'") != std::string::npos; }));
  EXPECT_TRUE(diagnose_legged(e, nullptr).evidence.findings.empty());
}

TEST(LeggedTracks, GapsAreFoundAndNothingCrossesThem) {
  std::vector<double> time;
  for (int i = 0; i < 100; ++i) time.push_back(0.01 * i + (i >= 60 ? 0.17 : 0.0));
  std::vector<Gap> gaps;
  const std::vector<Span> spans = find_spans(time, {}, 0.05, &gaps);
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_NEAR(gaps[0].to - gaps[0].from, 0.18, 1e-9);
  ASSERT_EQ(spans.size(), 2u);
  EXPECT_EQ(spans[0].end, 60u);
  EXPECT_EQ(spans[1].begin, 60u);
}

TEST(LeggedTracks, HeldSamplesAreNoNewReadings) {
  const std::vector<double> x{1, 1, 2, 2, 3}, y{5, 5, 5, 6, 6};
  EXPECT_EQ(find_new_samples({&x, &y}), (std::vector<char>{1, 0, 1, 1, 1}));
}

// A foot that reads 0 or 1 in the air and is read anew every second sample; a force that noise makes unique and that is
// not read for four samples.
TEST(LeggedTracks, ACountThatComesAgainIsReadAnewAndAUniqueReadingIsHeld) {
  const std::vector<double> counts{7, 7, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0},
      force{.31, .31, .42, .42, .42, .42, .53, .53, .64, .64, .75, .75};
  EXPECT_EQ(find_readings({&counts}, find_new_samples({&counts})),
            (std::vector<char>{1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0}));
  EXPECT_EQ(find_readings({&force}, find_new_samples({&force})),
            (std::vector<char>{1, 0, 1, 0, 0, 0, 1, 0, 1, 0, 1, 0}));
}

TEST(LeggedTracks, ALateTrackIsShiftedBackAndALagIsAsItsEquationHasIt) {
  // 2 Hz at 500 Hz: a line between samples errs by (2 pi 2 / 500)^2 / 8, 8e-5 of the amplitude.
  const double step = 0.002, way = 2 * M_PI * 2, time = 0.01, late = 0.013;
  Track x;
  for (int k = 0; k < 1000; ++k) {
    const double t = k * step;
    x.value.push_back(std::sin(way * t));
    x.rate.push_back(way * std::cos(way * t));
    x.second.push_back(-way * way * std::sin(way * t));
  }
  const Track ahead = shift_track(x, step, late), lagged = lag_track(x, step, time);
  for (size_t k = 200; k < 800; ++k) {  // 40 time constants after the beginning
    const double t = static_cast<double>(k) * step;
    EXPECT_NEAR(ahead.value[k], std::sin(way * (t + late)), 2e-4);
    const double expected = (std::sin(way * t) - way * time * std::cos(way * t)) / (1 + way * way * time * time);
    EXPECT_NEAR(lagged.value[k], expected, 2e-4);
    EXPECT_NEAR(lagged.value[k] + time * lagged.rate[k], x.value[k], 1e-12);  // the equation itself
  }
}

// A leg of 8 kg falls onto its sole at 0.1 to 0.3 m/s and is then pressed by up to 300 N more, m z'' = weight + leg -
// F, F = kz z + cz z' while that is positive. The other foot is rigid. Force and height have noise of 0.5 N and 20 um.
// A sole that is `rigid` makes the same force and does not sink. Of the leg, `rides` [kg] is below the force sensor, on
// the rubber.
std::vector<Landing> make_landings(double kz, double cz, bool rigid, double rate, double rides = 0) {
  constexpr double kMass = 8, kFine = 2e-5, kTouch = 0.1, kEnd = 0.25;
  std::mt19937 random(31);
  std::normal_distribution<double> normal;
  std::vector<Landing> out;
  for (int i = 0; i < 12; ++i) {
    Landing l;
    l.step = 1 / rate;
    l.foot = 0;
    l.other = 1;
    const double start = kTouch + 0.1 * i * l.step;  // anywhere between two samples
    double z = 0, v = 0.1 + 0.05 * (i % 5), next = 0;
    for (double t = 0; t < kEnd; t += kFine) {
      const double force = t >= start ? std::max(0.0, kz * z + cz * v) : 0;
      const double falls = 9.81 + (300 * std::clamp((t - start) / 0.05, 0.0, 1.0) - force) / kMass;
      if (t >= next) {
        l.force.push_back(force + rides * (falls - 9.81) + 0.5 * normal(random));
        l.others.push_back(300 - force + 0.5 * normal(random));
        l.height.push_back(0.01 * i - (rigid ? 0 : z) + 2e-5 * normal(random));
        l.flat.push_back(force > 50);
        next += l.step;
      }
      if (t < start) continue;
      v += kFine * falls;
      z += kFine * v;
    }
    out.push_back(std::move(l));
  }
  return out;
}

TEST(LeggedLandings, OfAMassOnASpringAndADamperTellBoth) {
  for (const double rate : {250.0, 500.0}) {
    const std::vector<SoleLaw> laws = fit_landings(make_landings(9e4, 350, false, rate), {1, 0});
    ASSERT_GT(laws[0].landings, 0u);
    EXPECT_EQ(laws[1].landings, 0u);
    EXPECT_NEAR(laws[0].kz, 9e4, 1.96 * laws[0].kz_std);
    EXPECT_NEAR(laws[0].cz, 350, 1.96 * laws[0].cz_std);
    EXPECT_LT(laws[0].kz_std, 0.02 * 9e4);
    EXPECT_LT(laws[0].cz_std, 0.15 * 350);
  }
}

// The sensor does not read what brakes the foot below it. A fit that takes the rubber's force for the reading finds too
// little lag.
TEST(LeggedLandings, BrakeTheFootBelowItsSensorToo) {
  std::vector<Landing> landings = make_landings(9e4, 350, false, 500, 0.8);
  const double bare = fit_landings(landings, {1, 0})[0].cz;
  for (Landing& l : landings) l.mass = 1.6;  // half of it is taken to ride on the rubber
  const SoleLaw law = fit_landings(landings, {1, 0})[0];
  EXPECT_LT(bare, 0.95 * 350);
  EXPECT_NEAR(law.cz, 350, 0.05 * 350);
  EXPECT_GT(law.cz_std, (law.cz - bare) / std::sqrt(12.0));  // from none of the foot to half of it
}

TEST(LeggedLandings, OnARigidSoleTellNothing) {
  const std::vector<SoleLaw> laws = fit_landings(make_landings(9e4, 350, true, 250), {1, 0});
  std::vector<Estimate> sole;
  EXPECT_FALSE(put_law(laws[0], &sole));
  EXPECT_TRUE(sole.empty());
}

// Stances that say another stiffness than landings do are right: they need no lag.
TEST(LeggedLandings, MustAgreeWithStances) {
  const SoleLaw law{9e4, 1e3, 350, 30, 12};
  std::vector<Estimate> near{{"kz", "N/m", {9.3e4}, {5e3}, false}}, far{{"kz", "N/m", {2e5}, {5e3}, false}};
  ASSERT_TRUE(put_law(law, &near));
  ASSERT_EQ(near.size(), 2u);
  EXPECT_EQ(near[0].value[0], 9e4);
  EXPECT_EQ(near[1].name, "cz");
  EXPECT_FALSE(put_law(law, &far));
  EXPECT_EQ(far.size(), 1u);
}

// Sliding friction is as large as its law says and points against the way. A force of that size that drives a foot on,
// or points anywhere, is another's.
TEST(LeggedChecks, SlidingFeetTellFrictionOnlyWhereTheirForcePointsBack) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> angle(-M_PI, M_PI);
  std::vector<Slide> back, onward, anywhere;
  for (int i = 0; i < 400; ++i) {
    const double ratio = 0.1 * (1 + 0.2 * normal(random)), cosine = std::cos(0.2 * normal(random));
    back.push_back({0, 0.05, ratio, cosine});
    onward.push_back({0, 0.05, ratio, -cosine});
    anywhere.push_back({0, 0.05, ratio, std::cos(angle(random))});
  }
  const auto [value, spread] = find_sliding_friction(back);
  EXPECT_NEAR(value, 0.1, 0.005);      // four errors of a median: 1.25 * 0.02 / sqrt(400) each
  EXPECT_NEAR(spread, 0.0135, 0.004);  // half the way between quartiles: 0.67 * 0.02
  EXPECT_EQ(find_sliding_friction(onward).first, 0);
  EXPECT_EQ(find_sliding_friction(anywhere).first, 0);
}

TEST(LeggedChecks, RecordingsThatDifferAreSetAside) {
  const Consensus k = find_consensus({1.026, 0.95, 1.031, 1.033}, 0.008);
  EXPECT_EQ(k.odd, 1u);
  EXPECT_NEAR(k.mean, 1.03, 1e-3);
}

// 10 N downwards 2 m ahead of the base: a moment of 20 N m about y holds it; the point is there, whatever plane is
// asked.
TEST(LoadShare, TheZeroMomentPointIsWhereAWeightHangs) {
  const Vector3d force(0, 0, 10), at(2, 0.3, -0.5);
  const Vector3d p = calc_zero_moment_point(at.cross(force), force, Vector3d::UnitZ(), Vector3d(0, 0, -0.9));
  EXPECT_LT((p - Vector3d(2, 0.3, -0.9)).norm(), 1e-12);
}

// 0.4 s with every sensor: the reason is their length, and no sensor is asked for.
TEST(LeggedObstacle, OfRecordingsThatAreTooShortIsTheirLength) {
  Experiment e = make_biped({}, kLeans);
  for (Recording& r : e.recordings) {
    r.time.resize(100);
    for (JointColumns& joint : r.joints) joint.signal[0].resize(100);
    for (auto& [name, column] : r.other) column.resize(100);
  }
  const std::string text = find_obstacle(e);
  EXPECT_NE(text.find("walk_0.csv lasts 0.4 s: too short"), std::string::npos) << text;
  EXPECT_EQ(text.find("/imu/"), std::string::npos) << text;
}

// One gyroscope over feet that are no flat soles: nothing is told twice.
TEST(LeggedObstacle, OfAnImuAloneIsWhatWouldTellTheSame) {
  Experiment e = make_biped({}, {.effort = false, .moments = false});
  for (Recording& r : e.recordings) {
    for (auto at = r.other.begin(); at != r.other.end();)
      at = at->first.find("angular") == std::string::npos ? r.other.erase(at) : std::next(at);
  }
  const std::string text = find_obstacle(e);
  EXPECT_NE(text.find("does not tell the same quantity twice"), std::string::npos) << text;
  EXPECT_NE(text.find("no column /base/pose/position/x"), std::string::npos) << text;
}

// What tells the same without the ground is compared; the rest is not, and nothing is claimed of it.
TEST(LeggedObstacle, WithoutFeetTheImuIsStillComparedWithTheMotion) {
  Experiment e = make_biped({});
  e.scenario.feet = {"no_link"};
  const LeggedReport report = diagnose_legged(e, [](const std::string&) {});
  EXPECT_TRUE(report.evidence.findings.empty());
  e.scenario.sensors.imus.clear();
  EXPECT_NE(find_obstacle(e).find("'feet' names no link that carries the robot"), std::string::npos)
      << find_obstacle(e);
}

}  // namespace
}  // namespace hrp::diagnosis::floating
