// SPDX-License-Identifier: BSD-3-Clause
// Angles of motors before their gears: weight follows the sine of the true angle, so no effect of the list stands for a
// ratio.
#include <gtest/gtest.h>

#include "diagnosis/conventions/gear_report.h"
#include "diagnosis/conventions/log_conventions.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

// Logs of an arm with friction and rotors, with angles of one joint that are `ratio` times its own.
Experiment make_geared(const std::string& name, int joint, double ratio, bool of_motor = false) {
  Experiment e = simulate_arm(name, make_arm_drives());
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) {
    JointColumns& columns = r.joints[static_cast<size_t>(joint)];
    for (int signal : {0, 1}) {
      for (double& x : columns.signal[signal]) x *= ratio;
    }
    for (double& y : columns.signal[2]) y /= of_motor ? ratio : 1.0;
  }
  return e;
}

TEST(GearReport, AnglesOfAnotherGearAreFoundWithTheirRatioAndConverted) {
  for (const double ratio : {0.5, 2.0}) {
    const Experiment e = make_geared("another_gear", kElbow, ratio);
    const Ratios found = find_gear_ratios(e, 1);
    ASSERT_EQ(found.found.size(), 1u) << ratio;
    EXPECT_EQ(found.found[0].joint, kElbow);
    EXPECT_NEAR(found.found[0].ratio, ratio, 1.96 * found.found[0].std);
    EXPECT_FALSE(found.found[0].of_motor);
    const double logged = e.recordings[0].joints[kElbow].signal[0][100];
    EXPECT_NEAR(convert_ratios(e, found).recordings[0].joints[kElbow].signal[0][100], logged / found.found[0].ratio,
                1e-9);
  }
}

// A gear keeps the power: the effort of the motor is that of the link over the ratio.
TEST(GearReport, EffortsOfTheMotorAreMultipliedByItsRatio) {
  const Ratios found = find_gear_ratios(make_geared("of_motor", kShoulder, 2.5, true), 1);
  ASSERT_EQ(found.found.size(), 1u);
  EXPECT_EQ(found.found[0].joint, kShoulder);
  EXPECT_NEAR(found.found[0].ratio, 2.5, 1.96 * found.found[0].std);
  EXPECT_TRUE(found.found[0].of_motor);
}

TEST(GearReport, FrictionRotorsAndAnotherZeroAreNoRatio) {
  Experiment e = make_geared("no_ratio", kElbow, 1.0);
  EXPECT_TRUE(find_gear_ratios(e, 1).found.empty());
  for (Recording& r : e.recordings) {
    for (double& q : r.joints[kShoulder].signal[0]) q += 0.5;
  }
  EXPECT_TRUE(find_gear_ratios(e, 1).found.empty());
}

// An upright joint with currents of 13 N m: its rotor takes what another gear changes of the torque, and the unit does
// the rest.
TEST(GearReport, CurrentsOfAnUprightJointAreNoEffortsOfAMotorBeforeItsGear) {
  std::string upright = kArm;
  upright.replace(upright.find("axis xyz=\"0 1 0\""), 16, "axis xyz=\"0 0 1\"");
  Experiment e = make_simulated_experiment("upright_currents", upright, kArmJoints, make_arm_drives());
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) {
    for (JointColumns& joint : r.joints) {
      for (double& y : joint.signal[2]) y /= 13.0;
    }
  }
  EXPECT_TRUE(find_gear_ratios(e, 1).found.empty());
}

// What is named beside a ratio that recordings do not agree about may be the ratio's.
TEST(GearReport, ADoubtedRatioLeavesNothingSupportedAtItsJoint) {
  const Experiment e = make_geared("doubted", kElbow, 1.0);
  Ratios ratios;
  ratios.doubted.push_back({kElbow, 2.0, 0.2, false, 0.5, false});
  Reports reports;
  reports.report["warnings"] = Json::array();
  reports.series["notes"] = Json::array();
  const auto make = [](const char* effect, const Json& where) {
    return Json{{"effect", effect},
                {"where", where},
                {"grade", "supported"},
                {"alternatives", Json::array()},
                {"statement", ""}};
  };
  reports.report["findings"] = {make("coulomb_friction", {{"joint", "elbow"}}), make("com_error", {{"link", "fore"}}),
                                make("coulomb_friction", {{"joint", "shoulder"}})};
  doubt_ratios(e, ratios, &reports);
  EXPECT_EQ(reports.report["findings"][0]["grade"], "ambiguous");
  EXPECT_EQ(reports.report["findings"][1]["grade"], "ambiguous");
  EXPECT_EQ(reports.report["findings"][1]["alternatives"][0]["effect"], "sensor_scale");
  EXPECT_EQ(reports.report["findings"][2]["grade"], "supported");
  EXPECT_EQ(reports.report["warnings"].size(), 1u);
}

}  // namespace
}  // namespace hrp::diagnosis
