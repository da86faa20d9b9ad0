// SPDX-License-Identifier: BSD-3-Clause
// Findings on a biped of our own that walks, with one cause hidden in each case.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "diagnosis/floating/diagnose.h"
#include "tests/unit/diagnosis/legged/biped.h"
#include "tests/unit/diagnosis/legged/late_columns.h"

namespace hrp::diagnosis::floating {
namespace {

TEST(Legged, NothingHiddenNamesNothing) {
  const Evidence e = diagnose_biped({});
  EXPECT_TRUE(e.findings.empty());
  EXPECT_EQ(e.verdict, Verdict::kNoMismatch);
}

TEST(Legged, LoadOnThePelvisHasItsMassAndPlace) {
  Hidden hidden;
  hidden.load = 2.5;
  hidden.place = {0.05, -0.04, 0.2};
  const Evidence e = diagnose_biped(hidden);
  ASSERT_EQ(e.findings.size(), 1u);
  EXPECT_EQ(e.findings[0].effect, "payload");
  EXPECT_EQ(e.findings[0].where.at("link"), "pelvis");
  EXPECT_NEAR(e.findings[0].parameters[0].value[0], 2.5, 0.05);  // 2 %: noise of 200 s of cells is far below
  EXPECT_NEAR(e.findings[0].parameters[1].value[1], -0.04, 0.01);
}

void expect_named(const char* carrier, const Vector3d& place, double mass) {
  Hidden hidden;
  hidden.load = mass;
  hidden.place = place;
  hidden.carrier = carrier;
  const Evidence e = diagnose_biped(hidden);
  SCOPED_TRACE(std::string(carrier) + ", kg: " + std::to_string(mass));
  ASSERT_EQ(e.findings.size(), 1u);
  EXPECT_EQ(e.findings[0].effect, "payload");
  EXPECT_EQ(e.findings[0].where.at("link"), carrier);
  const std::vector<Estimate>& p = e.findings[0].parameters;
  EXPECT_NEAR(p[0].value[0], mass, 1.96 * p[0].std[0]);  // its own interval
  for (size_t a = 0; a < 3; ++a)
    EXPECT_NEAR(p[1].value[a], place(static_cast<long>(a)), std::max(0.01, 1.96 * p[1].std[a]));
}

// The robot weighs 35 kg: loads of 1 to 20 % of it, and of each on each link at night.
const std::pair<const char*, Vector3d> kCarriers[] = {
    {"pelvis", {0.05, -0.04, 0.2}}, {"l_thigh", {0.06, 0.05, -0.12}}, {"r_shank", {0.05, -0.04, -0.1}}};
constexpr double kLoads[] = {0.35, 2.0, 7.0};

TEST(Legged, LoadsFromLightToHeavyAreNamedOnTheirLinks) {
  for (size_t i = 0; i < 3; ++i) expect_named(kCarriers[i].first, kCarriers[i].second, kLoads[i]);
}

TEST(LeggedNightly, EachOfTheLoadsIsNamedOnEachOfTheLinks) {
  for (const auto& [carrier, place] : kCarriers) {
    for (const double mass : kLoads) expect_named(carrier, place, mass);
  }
}

TEST(Legged, DryFrictionIsNamedInItsJoint) {
  Hidden hidden;
  hidden.dry = 3;
  const Evidence e = diagnose_biped(hidden);
  ASSERT_EQ(e.findings.size(), 1u);
  EXPECT_EQ(e.findings[0].effect, "coulomb_friction");
  EXPECT_EQ(e.findings[0].where.at("joint"), "l_knee");
  EXPECT_NEAR(e.findings[0].parameters[0].value[0], 3, 0.3);  // 10 %: the kernel rounds each reversal
}

TEST(Legged, RotorIsNamedInItsJoint) {
  Hidden hidden;
  hidden.rotor = 0.2;
  const Evidence e = diagnose_biped(hidden);
  ASSERT_EQ(e.findings.size(), 1u);
  EXPECT_EQ(e.findings[0].effect, "rotor_inertia");
  EXPECT_NEAR(e.findings[0].parameters[0].value[0], 0.2, 0.02);
}

// The shaft gives, or the thigh or the pelvis beside it bends: nothing that is recorded tells where.
TEST(Legged, AnElasticHipIsListedBesideTheLinksThatMayBendThere) {
  Hidden hidden;
  hidden.give = 1.0 / 800;
  const Evidence e = diagnose_biped(hidden, {.leans = true});
  ASSERT_EQ(e.findings.size(), 1u);
  const Finding& f = e.findings[0];
  EXPECT_EQ(f.effect, "joint_elasticity");
  EXPECT_EQ(f.where.at("joint"), "l_hip");
  EXPECT_EQ(f.grade, Grade::kAmbiguous);
  EXPECT_NEAR(f.parameters[0].value[0], 800, 1.96 * f.parameters[0].std[0]);  // its own interval
  std::vector<std::string> links;
  for (const Alternative& a : f.alternatives) {
    if (a.effect == "link_bending") links.push_back(a.where.at("link"));
  }
  EXPECT_EQ(links, (std::vector<std::string>{"pelvis", "l_thigh"}));
}

TEST(Legged, ForcesOfFlatFeetBalanceWithoutTheirMoments) {
  EXPECT_EQ(diagnose_biped({}, {.leans = true, .moments = false}).verdict, Verdict::kNoMismatch);
  Hidden hidden;
  hidden.push = 60;
  const Evidence e = diagnose_biped(hidden, {.leans = true, .moments = false});
  EXPECT_TRUE(e.findings.empty());
  EXPECT_EQ(e.verdict, Verdict::kUnexplained) << "a hand that pushes aside is no vertical force";
}

// No table holds a tether or a beam that bends: what is asked of the report is the place, and no name in their stead.
TEST(Legged, ATetherIsNoEffectButAForceAtItsLink) {
  Hidden hidden;
  hidden.tether = 600;
  const Evidence e = diagnose_biped(hidden, {.leans = true});
  EXPECT_TRUE(e.findings.empty());
  EXPECT_EQ(e.verdict, Verdict::kUnexplained);
  ASSERT_FALSE(e.remaining.empty());
  EXPECT_EQ(e.remaining[0].where.at("link"), "pelvis");
  EXPECT_NE(e.remaining[0].statement.find("pulls"), std::string::npos);
}

TEST(Legged, AHipThatBendsAcrossItsAxisIsToldAtThatHip) {
  Hidden hidden;
  hidden.bend = 1.0 / 1500;
  const Evidence e = diagnose_biped(hidden, {.leans = true});
  EXPECT_TRUE(e.findings.empty());
  ASSERT_FALSE(e.remaining.empty());
  EXPECT_EQ(e.remaining[0].where.at("joint"), "l_hip");
  EXPECT_NE(e.remaining[0].statement.find("bends"), std::string::npos);
}

// Its inertia about the hip grows by a third: without that in its column, a torque constant or a rotor stands in for
// it.
TEST(Legged, MassThatLiesElsewhereAlsoTurnsOtherwise) {
  Hidden hidden;
  hidden.lower = 0.05;
  const Evidence e = diagnose_biped(hidden);
  ASSERT_EQ(e.findings.size(), 1u);
  EXPECT_EQ(e.findings[0].effect, "com_error");
  EXPECT_EQ(e.findings[0].where.at("link"), "l_thigh");
  EXPECT_NEAR(e.findings[0].parameters[0].value[2], -0.05, 0.0025);  // 5 %: to which equations are exact here
}

TEST(Legged, ScaleOfOneForceSensorIsNoMass) {
  Hidden hidden;
  hidden.force_scale = 1.06;
  const Evidence e = diagnose_biped(hidden);
  ASSERT_EQ(e.findings.size(), 1u);
  EXPECT_EQ(e.findings[0].effect, "sensor_scale");
  EXPECT_EQ(e.findings[0].where.at("sensor"), "/wrench/l/force");
  EXPECT_NEAR(e.findings[0].parameters[0].value[0], 1.06, 0.005);
}

TEST(Legged, VerticalForcesAloneCannotTellALoadFromAScale) {
  Hidden hidden;
  hidden.load = 1.5;
  hidden.dry = 3;
  Recorded recorded;
  recorded.six_axes = recorded.effort = false;
  const Evidence e = diagnose_biped(hidden, recorded);
  ASSERT_FALSE(e.findings.empty());
  EXPECT_EQ(e.findings[0].grade, Grade::kAmbiguous);
  std::vector<std::string> names{e.findings[0].effect};
  for (const Alternative& a : e.findings[0].alternatives) names.push_back(a.effect);
  for (const char* name : {"mass_error", "payload", "sensor_scale", "sensor_bias"}) {
    EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << name;
  }
  for (const Finding& f : e.findings) EXPECT_NE(f.effect, "coulomb_friction");
  EXPECT_FALSE(e.missing.empty());
}

// On a bus that is late all force sensors are: one delay, not one of each.
TEST(Legged, ForceSensorsThatAreLateTogetherHaveOneDelay) {
  Recorded recorded;
  recorded.effort = false;
  Experiment e = make_biped({}, recorded);
  delay_columns("/wrench/", 7, &e);
  expect_delay_alone(e, "/wrench", 7);
}

// The rate of the body, its slope and its specific force are late together: one delay, and no lag of the drives.
TEST(Legged, AnImuThatIsLateInAWalkIsNoLagOfTheDrives) {
  Experiment e = make_biped({});
  delay_columns("/imu/", 3, &e);
  expect_delay_alone(e, "/imu/waist", 3);
}

// What a body that stands on all feet feels, less 0.5 m/s^2, and with an alternating part [m/s^2].
bool is_gravity_off(double chatter) {
  Recorded recorded;
  recorded.effort = false;
  recorded.leans = true;
  Experiment e = make_biped({}, recorded);
  for (Recording& r : e.recordings) {
    std::vector<double>& up = r.other.at("/imu/waist/linear_acceleration/z");
    for (size_t k = 0; k < up.size(); ++k) up[k] += -0.5 + (k / 40 % 2 ? chatter : -chatter);
  }
  const Evidence found = diagnose_legged(e, nullptr).evidence;
  for (const std::string& note : found.warnings) {
    if (note.find("of gravity") != std::string::npos) return true;
  }
  return std::any_of(found.findings.begin(), found.findings.end(),
                     [](const Finding& f) { return f.where.dump().find("linear_acceleration") != std::string::npos; });
}

// The mean of feet that chatter and of falls has what was sampled too slowly.
TEST(Legged, GravityIsComparedOnlyWhileTheBodyIsStill) {
  EXPECT_TRUE(is_gravity_off(0));
  EXPECT_FALSE(is_gravity_off(3));
}

// The weight rests on the one foot that is felt while the other swings.
TEST(Legged, OneFootsForceTellsTheWeightWhileTheOtherSwings) {
  Recorded recorded;
  recorded.effort = recorded.right_foot = false;
  const LeggedReport report = diagnose_legged(make_biped({}, recorded), nullptr);
  EXPECT_TRUE(report.judged);
  for (const Finding& f : report.evidence.findings) EXPECT_NE(f.family, "mass and its place") << f.statement;
}

TEST(Legged, RawCountsAreNoNewtons) {
  Recorded recorded;
  recorded.six_axes = recorded.effort = false;
  recorded.unit = 8;
  const Evidence e = diagnose_biped({}, recorded);
  ASSERT_EQ(e.findings.size(), 2u);
  for (const Finding& f : e.findings) {
    EXPECT_EQ(f.effect, "sensor_scale");
    EXPECT_NEAR(f.parameters[0].value[0], 8, 0.4);  // 5 %: where the load lies between the feet is not known
  }
}

}  // namespace
}  // namespace hrp::diagnosis::floating
