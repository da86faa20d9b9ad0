// SPDX-License-Identifier: BSD-3-Clause
// Losses and rotors in every drive of a robot that walks, beside one fault of its body or its sensors.
#include "diagnosis/many_drives/legged.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>

#include "diagnosis/findings/doubtful_constants.h"
#include "diagnosis/many_drives/legged_torques.h"
#include "tests/unit/diagnosis/legged/biped.h"

namespace hrp::diagnosis::floating {
namespace {

const Hidden kDrives{.every = 2.0, .every_viscous = 3.0, .every_rotor = 0.3};
const std::map<std::string, double> kTrue{{"coulomb_friction", 2.0}, {"viscous_friction", 3.0}, {"rotor_inertia", 0.3}};

Json diagnose_drives(const Hidden& hidden, const Recorded& recorded = {}) {
  Experiment e = make_biped(hidden, recorded);
  e.joint_noise.assign(6, std::vector<Noise>(kQuantities));
  Reports out;
  const bool judged = many_drives::diagnose_legged(
      e, 1, [](const std::string&) {}, &out);
  return judged ? out.report : Json();
}

// "effect joint" of the supported findings of joints, and that each is true.
std::set<std::string> list_supported(const Json& report) {
  std::set<std::string> out;
  for (const Json& f : report["findings"]) {
    if (f["grade"] == "ambiguous" || !f["where"].contains("joint")) continue;
    const std::string effect = f["effect"], joint = f["where"]["joint"];
    out.insert(effect + " " + joint);
    EXPECT_EQ(kTrue.count(effect), 1u) << f["statement"];
    if (kTrue.count(effect) == 0) continue;
    const Json& p = f["parameters"].begin().value();
    // 10 %: the filter rounds each reversal, and the three effects of a joint share its torque.
    EXPECT_NEAR(p["value"].get<double>(), kTrue.at(effect), 0.1 * kTrue.at(effect)) << f["statement"];
  }
  return out;
}

TEST(ManyDrives, FrictionAndRotorOfEveryJointOfAWalkingRobotAreNamed) {
  const Json report = diagnose_drives(kDrives);
  ASSERT_FALSE(report.is_null());
  EXPECT_EQ(list_supported(report).size(), 18u) << report["summary"];
  EXPECT_EQ(report["verdict"], "mostly_explained");
}

TEST(ManyDrives, ADisplacedCentreOfMassDoesNotReachTheJoints) {
  Hidden hidden = kDrives;
  hidden.lower = 0.05;  // [m] of the left thigh's
  const Json report = diagnose_drives(hidden);
  ASSERT_FALSE(report.is_null());
  EXPECT_EQ(list_supported(report).size(), 18u) << report["summary"];
  const auto& found = report["findings"];
  EXPECT_TRUE(std::any_of(found.begin(), found.end(), [](const Json& f) {
    return f["effect"] == "com_error" && f["where"] == Json{{"link", "l_thigh"}};
  })) << report["summary"];
}

TEST(ManyDrives, AFootSensorOfWrongScaleIsNamedBesideThem) {
  Hidden hidden = kDrives;
  hidden.force_scale = 1.08;
  const Json report = diagnose_drives(hidden);
  ASSERT_FALSE(report.is_null());
  EXPECT_EQ(list_supported(report).size(), 18u) << report["summary"];
  const auto& found = report["findings"];
  EXPECT_TRUE(std::any_of(found.begin(), found.end(), [](const Json& f) {
    return f["effect"] == "sensor_scale" && f["where"] == Json{{"sensor", "/wrench/l/force"}} &&
           std::abs(f["parameters"]["scale"]["value"].get<double>() - 1.08) < 0.01;
  })) << report["summary"];
}

// A robot whose drives are as stated, or with one loss, is left to the search for single effects.
// Samples in which the torques of all joints are known.
long count_known(const Experiment& e) {
  many_drives::LeggedLogs logs{make_legged_log(e, Half::kAll), make_legged_log(e, Half::kEven), {}};
  logs.contacts = find_contacts(logs.smooth);
  long known = 0;
  for (const TorqueRecording& r : many_drives::make_legged_torques(logs).recordings)
    known += (r.known.size() > 0 ? r.known.rowwise().all().count() : r.tau.rows());
  return known;
}

// Every half second, a joint of a robot that leans slips, and its foot jerks by 20 N for a sample.
TEST(ManyDrives, JerksOfFeetThatStayAreNoLandingsAndHideNoTorque) {
  Experiment e = make_biped(kDrives, {.leans = true});
  e.joint_noise.assign(6, std::vector<Noise>(kQuantities));
  const long smooth = count_known(e);
  for (Recording& r : e.recordings) {
    for (auto& [column, values] : r.other) {
      if (column.find("/force/z") == std::string::npos) continue;
      for (size_t k = 50; k < values.size(); k += 100) values[k] += 20.0;
    }
  }
  EXPECT_GT(smooth, 0);
  EXPECT_EQ(count_known(e), smooth);
}

// An Atlas whose feet read 5 N too much to the side gets 5 N m in both hips, 1 m above. A foot that lifts shows that
// zero.
TEST(DoubtfulConstants, OfAHipMayBeTheZeroOfTheForceUnderAFootThatNeverLifts) {
  const auto grade_hip = [](double torque, double least) {
    Experiment e = make_biped({}, {.leans = true});
    const std::string sensor = e.scenario.sensors.wrenches.at(0).name;
    for (Recording& r : e.recordings) {
      std::vector<double>& force = r.other.at("/wrench/" + sensor + "/force/z");
      std::fill(force.begin(), force.end(), 170.0);
      force.front() = least;
    }
    Json report;
    report["findings"] = {{{"effect", "constant_torque"},
                           {"grade", "supported"},
                           {"where", {{"joint", "l_hip"}}},
                           {"parameters", {{"torque", {{"value", torque}, {"std", 0.1}, {"unit", "N m"}}}}},
                           {"alternatives", Json::array()}}};
    doubt_constants_of_feet(e, &report);
    return report["findings"][0];
  };
  const Json small = grade_hip(1.0, 170.0);
  EXPECT_EQ(small["grade"], "ambiguous");
  ASSERT_EQ(small["alternatives"].size(), 1u);
  EXPECT_EQ(small["alternatives"][0]["effect"], "sensor_bias");
  EXPECT_EQ(grade_hip(1.0, 2.0)["grade"], "supported") << "the foot lifts";
  EXPECT_EQ(grade_hip(50.0, 170.0)["grade"], "supported") << "no zero is as large as a tenth of the weight";
}

TEST(ManyDrives, OneLossIsNoRobotWithLossesEverywhere) {
  EXPECT_TRUE(diagnose_drives({}).is_null());
  EXPECT_TRUE(diagnose_drives({.dry = 3.0}).is_null());
}

}  // namespace
}  // namespace hrp::diagnosis::floating
