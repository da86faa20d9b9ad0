// SPDX-License-Identifier: BSD-3-Clause
// Findings on the biped while both feet stay where they are, by encoders and force sensors, at most with an IMU.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "diagnosis/floating/diagnose.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "tests/unit/diagnosis/legged/biped.h"
#include "tests/unit/diagnosis/legged/late_columns.h"

namespace hrp::diagnosis::floating {
namespace {

TEST(LeggedLeans, NothingHiddenNamesNothing) {
  const Evidence e = diagnose_biped({}, kLeans);
  EXPECT_TRUE(e.findings.empty());
  EXPECT_EQ(e.verdict, Verdict::kNoMismatch);
}

TEST(LeggedLeans, LoadIsFoundWithoutAnImu) {
  Hidden hidden;
  hidden.load = 2.5;
  hidden.place = {0.05, 0, 0.2};
  const Evidence e = diagnose_biped(hidden, kLeans);
  ASSERT_FALSE(e.findings.empty());
  std::vector<std::string> families{e.findings[0].family};
  EXPECT_EQ(e.findings[0].family, "mass and its place");
  EXPECT_EQ(e.findings[0].where.at("link"), "pelvis");
}

// Whether a fault of an accelerometer is named whose readings are this factor times too large.
bool names_accelerometer(double factor) {
  Recorded recorded = kLeans;
  recorded.imu = true;
  Experiment e = make_biped({}, recorded);
  scale_readings("/imu/waist/linear_acceleration", factor, &e);
  const std::vector<Finding> findings = diagnose_legged(e, nullptr).evidence.findings;
  return std::any_of(findings.begin(), findings.end(),
                     [](const Finding& f) { return f.where.dump().find("linear_acceleration") != std::string::npos; });
}

TEST(LeggedLeans, AnAccelerometerWithinItsDataSheetHasNoFault) {
  EXPECT_FALSE(names_accelerometer(1.005));
  EXPECT_TRUE(names_accelerometer(1.03));
}

// Every force and every moment is 4 % larger: the masses are, or the sensors' readings.
TEST(LeggedLeans, MassesThatAreWrongByOneFactorAreListedBesideTheScaleOfAllForceSensors) {
  Hidden hidden;
  hidden.heavier = 1.04;
  const Evidence e = diagnose_biped(hidden, kLeans);
  ASSERT_EQ(e.findings.size(), 1u);
  const Finding& f = e.findings[0];
  EXPECT_EQ(f.grade, Grade::kAmbiguous);
  bool scale = f.effect == "sensor_scale" && f.where.at("sensor") == "/wrench", mass = f.family == "mass and its place";
  for (const Alternative& a : f.alternatives) {
    scale = scale || (a.effect == "sensor_scale" && a.where.at("sensor") == "/wrench");
    mass = mass || a.family == "mass and its place";
  }
  EXPECT_TRUE(scale) << f.statement;
  EXPECT_TRUE(mass) << f.statement;
}

TEST(LeggedLeans, ZeroOfAMomentIsFoundAtItsSensor) {
  Hidden hidden;
  hidden.zero_y = 3;
  const Evidence e = diagnose_biped(hidden, kLeans);
  ASSERT_EQ(e.findings.size(), 1u);
  EXPECT_EQ(e.findings[0].effect, "sensor_bias");
  EXPECT_EQ(e.findings[0].where.at("sensor"), "/wrench/l/torque");
  EXPECT_NEAR(e.findings[0].parameters[0].value[1], 3, 0.15);  // 5 %: what equations are exact to
}

// Moments about the base would tell whose it is, but for a zero of the other sensor's moment, which makes the same.
TEST(LeggedLeans, ZeroOfAForceMayBeTheOtherFootsWhileFeetStay) {
  Experiment e = make_biped({}, kLeans);
  for (Recording& r : e.recordings) {
    for (double& force : r.other.at("/wrench/l/force/z")) force += 6;
  }
  const Evidence found = diagnose_legged(e, nullptr).evidence;
  ASSERT_FALSE(found.findings.empty());
  const Finding& f = found.findings[0];
  EXPECT_EQ(f.effect, "sensor_bias");
  EXPECT_EQ(f.grade, Grade::kAmbiguous);
  EXPECT_TRUE(std::any_of(f.alternatives.begin(), f.alternatives.end(), [](const Alternative& a) {
    return a.effect == "sensor_bias" && a.where.at("sensor") == "/wrench/r/force";
  })) << f.statement;
}

// Who sways a robot by hand adds a force that nobody recorded: one equation keeps it, the others are as they were.
TEST(LeggedLeans, AHandThatPushesLeavesNoDoubtAboutTheZeroOfAMoment) {
  Hidden hidden;
  hidden.zero_y = 0.4;
  hidden.push = 200;
  const Evidence e = diagnose_biped(hidden, kLeans);
  const auto zero =
      std::find_if(e.findings.begin(), e.findings.end(), [](const Finding& f) { return f.effect == "sensor_bias"; });
  ASSERT_NE(zero, e.findings.end());
  EXPECT_EQ(zero->where.at("sensor"), "/wrench/l/torque");
  ASSERT_LT(e.explained, 0.25) << "the push is most of what the equations miss";
  EXPECT_EQ(zero->statement.find("Most of what stands out is left"), std::string::npos) << zero->statement;
  EXPECT_NE(e.verdict, Verdict::kExplained);
}

// An ankle's zero would have one sole askew against the other one.
TEST(LeggedLeans, ASensorThatIsTurnedIsToldFromItsAnklesZero) {
  Hidden hidden;
  hidden.turn = {0, 0.06, 0};
  const Evidence e = diagnose_biped(hidden, kLeans);
  ASSERT_EQ(e.findings.size(), 1u);
  const Finding& turned = e.findings[0];
  EXPECT_EQ(turned.effect, "sensor_misalignment");
  EXPECT_EQ(turned.where.at("sensor"), "/wrench/l");
  EXPECT_EQ(turned.grade, Grade::kSupported);
  EXPECT_NEAR(turned.parameters[0].value[1], 0.06, 0.006);  // 10 %: a turn is as large as its sine to 1 %
}

// Nothing but encoders and feet that stand tells how the body turns.
TEST(LeggedLeans, AnImuThatIsLateIsFoundOverStandingFeet) {
  Recorded recorded = kLeans;
  recorded.imu = true;
  Experiment e = make_biped({}, recorded);
  delay_columns("/imu/", 3, &e);
  const Evidence found = diagnose_legged(e, nullptr).evidence;
  ASSERT_FALSE(found.findings.empty());
  const Finding& f = found.findings[0];
  EXPECT_EQ(f.effect, "sensor_delay");
  EXPECT_EQ(f.where.at("sensor").get<std::string>().rfind("/imu/waist", 0), 0u);
  EXPECT_NEAR(f.parameters[0].value[0], 3 * 0.004, 0.0012);  // a tenth of it: 1 ms is a quarter of a sample
}

// A load makes most of the mismatch of forces. What late force sensors make is little beside it, and most of what is
// left.
TEST(LeggedWalks, LateForceSensorsAreFoundBesideALoadAndAScale) {
  Hidden hidden;
  hidden.load = 2.5;
  hidden.place = {0.05, 0, 0.2};
  hidden.force_scale = 1.04;
  Experiment e = make_biped(hidden, {.effort = false});
  delay_columns("/wrench/", 2, &e);
  const Evidence found = diagnose_legged(e, nullptr).evidence;
  const auto late = std::find_if(found.findings.begin(), found.findings.end(),
                                 [](const Finding& f) { return f.effect == "sensor_delay"; });
  ASSERT_NE(late, found.findings.end());
  EXPECT_EQ(late->where.at("sensor"), "/wrench");
  EXPECT_NEAR(late->parameters[0].value[0], 2 * 0.004, 0.002);  // half a sample
  EXPECT_TRUE(std::any_of(found.findings.begin(), found.findings.end(),
                          [](const Finding& f) { return f.family == "mass and its place"; }));
}

// The body leans about y alone. About x and z the gyroscope reads its zero and noise, and that is no sign of feet that
// turn.
TEST(LeggedLeans, AGyroscopesZeroIsFoundAboutAxesThatNothingTurnsAbout) {
  Recorded recorded = kLeans;
  recorded.imu = true;
  Experiment e = make_biped({}, recorded);
  const double zero[] = {0.01, -0.02, 0.008};  // [rad/s]
  for (Recording& r : e.recordings) {
    for (int a = 0; a < 3; ++a) {
      for (double& w : r.other.at(std::string("/imu/waist/angular_velocity/") + "xyz"[a])) w += zero[a];
    }
  }
  const Evidence found = diagnose_legged(e, nullptr).evidence;
  const auto f = std::find_if(found.findings.begin(), found.findings.end(), [](const Finding& g) {
    return g.where.dump().find("angular_velocity") != std::string::npos;
  });
  ASSERT_NE(f, found.findings.end());
  EXPECT_EQ(f->effect, "sensor_bias");
  for (size_t a = 0; a < 3; ++a)
    EXPECT_NEAR(f->parameters[0].value[a], zero[a], 0.0005);  // noise 1e-3, over 2000 samples
}

// Feet that stay on a slope: zeros of all legs, or an IMU that sits askew, are the same constant.
TEST(LeggedLeans, ASlopeUnderFeetThatStayIsListedBesideAnklesZerosAndTheImu) {
  Hidden hidden;
  hidden.slope = 0.04;
  Recorded recorded = kLeans;
  recorded.imu = true;
  recorded.six_axes = false;
  const Evidence found = diagnose_biped(hidden, recorded);
  ASSERT_EQ(found.findings.size(), 1u);
  const Finding& f = found.findings[0];
  EXPECT_EQ(f.effect, "ground_slope") << f.statement;
  EXPECT_EQ(f.grade, Grade::kAmbiguous);
  int zeros = 0, askew = 0;
  for (const Alternative& a : f.alternatives) {
    zeros += a.effect == "joint_offset";
    askew += a.effect == "sensor_misalignment";
  }
  EXPECT_GE(zeros, 2) << "one of each ankle";
  EXPECT_GE(askew, 1);
}

// 150 N at the edge of the sole would turn it by 375 rad.
TEST(LeggedLeans, AnAnkleThatWouldTurnByRadiansIsNoElasticJoint) {
  const Experiment e = make_biped({}, kLeans);
  const LeggedLog log = make_legged_log(e, Half::kEven);
  int checked = 0;
  for (const Candidate& c : list_candidates(log, ColumnLayout(log))) {
    if (c.law != &get_laws().elasticity || c.where.at("joint") != "l_ankle") continue;
    EXPECT_FALSE(is_sensible(c, Eigen::VectorXd::Constant(1, 1 / 0.04)));
    EXPECT_TRUE(is_sensible(c, Eigen::VectorXd::Constant(1, 1 / 100.0)));
    ++checked;
  }
  EXPECT_EQ(checked, 1);
}

// Both soles lie on one ground, and the encoders have one of them askew: encoders and forces are enough.
TEST(LeggedLeans, AKneesZeroIsFoundFromTheClosedChainOfTheLegs) {
  for (const bool six_axes : {true, false}) {
    Recorded recorded = kLeans;
    recorded.six_axes = six_axes;
    Experiment e = make_biped({}, recorded);
    for (Recording& r : e.recordings) {
      for (double& angle : r.joints[1].signal[0]) angle += 0.03;
    }
    const std::vector<Finding> findings = diagnose_legged(e, nullptr).evidence.findings;
    ASSERT_EQ(findings.size(), 1u);
    const Finding& f = findings[0];
    ASSERT_EQ(f.effect, "joint_offset") << f.statement;
    const bool left = f.where.at("joint") == "l_knee";
    EXPECT_NEAR(f.parameters[0].value[0], left ? 0.03 : -0.03, 0.0015);  // 5 %: what equations are exact to
    EXPECT_TRUE(left || !six_axes) << "moments tell which of the legs it is";
    EXPECT_TRUE(left || std::any_of(f.alternatives.begin(), f.alternatives.end(), [](const Alternative& a) {
                  return a.effect == "joint_offset" && a.where.at("joint") == "l_knee";
                }));
  }
}

}  // namespace
}  // namespace hrp::diagnosis::floating
