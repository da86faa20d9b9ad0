// SPDX-License-Identifier: BSD-3-Clause
// What a report says where the log does not tell the unit of its efforts.
#include <gtest/gtest.h>

#include "diagnosis/conventions/effort_units.h"
#include "diagnosis/conventions/log_conventions.h"
#include "diagnosis/conventions/unit_doubts.h"
#include "diagnosis/data/stretches.h"
#include "diagnosis/diagnose_recordings.h"
#include "tests/unit/diagnosis/heavy_disc.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

// A motor that turns a disc against friction, logged in hundredths: nothing tells that they are no N m.
TEST(UntoldUnits, WhatIsFoundWhereTheUnitIsNotToldIsInTheUnitOfTheLog) {
  Experiment e =
      make_simulated_experiment("units_untold", kDisc, {"motor"},
                                {{EffectId::kCoulomb, 0, {1.0, 0.0, 5e-4}}, {EffectId::kRotorInertia, 0, {0.1}}});
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) r = cut_recording(r, 0, r.time.size() / 2);  // 3 s tell as little of the unit
  const Json report = diagnose_recordings(
                          e, {}, [](const std::string&) {}, [](const Reports&) {})
                          .report;
  ASSERT_FALSE(report["findings"].empty());
  EXPECT_EQ(report["untold_units"], Json({"motor"}));
  EXPECT_NE(report["warnings"].dump().find("/joint_states/motor/effort: this motion does not tell its unit"),
            std::string::npos);
  EXPECT_NE(report["summary"].get<std::string>().find("the unit of the effort of motor"), std::string::npos)
      << report["summary"];
  for (const Json& f : report["findings"]) EXPECT_TRUE(f.contains("in_log_unit")) << f["statement"];
  // Errors of this effort neither.
  const std::string summary = report["summary"], errors = summary.substr(summary.find("efforts from "));
  EXPECT_NE(errors.substr(0, errors.find(". ")).find("(unit of the log)"), std::string::npos) << errors;
  for (const Json& r : report["remaining"])
    EXPECT_NE(r["statement"].get<std::string>().find("in the unit of the log"), std::string::npos) << r["statement"];
}

// A heavy disc with the current of its motor as effort: it takes a fortieth of what is logged, as a rotor of 39 discs
// would.
TEST(UntoldUnits, ARotorThatTheUnitMayBeIsNotSure) {
  Experiment e = simulate_heavy_disc("units_rotor");
  for (Recording& r : e.recordings) {
    for (double& y : r.joints[0].signal[2]) y *= 40.0;
  }
  Reports reports;
  reports.report["findings"] = {{{"effect", "rotor_inertia"},
                                 {"where", {{"joint", "motor"}}},
                                 {"grade", "supported"},
                                 {"statement", ""},
                                 {"alternatives", Json::array()},
                                 {"parameters", {{"inertia", {{"value", 7.8}, {"unit", "kg m^2"}}}}}}};
  doubt_untold_units(e, list_untold_units(make_torque_data(e), {}), &reports);
  const Json& rotor = reports.report["findings"][0];
  EXPECT_EQ(rotor["grade"], "ambiguous");
  ASSERT_EQ(rotor["alternatives"].size(), 1u);
  EXPECT_NEAR(rotor["alternatives"][0]["parameters"]["scale"]["value"].get<double>(), 1.0 / 40.0,
              0.1 / 40.0);  // a tenth, as above
}

// A motor at full duty, 100 in either direction, of 0.003 N m each, against viscous friction (back-EMF) of 0.02 N m
// s/rad. Dry friction of 99.7 N m beside efforts in N m would make the same step.
Experiment make_steps(const std::string& name) {
  Experiment e = make_simulated_experiment(name, kDisc, {"motor"}, {});
  e.scenario.drive = "effort";
  TestNoise noise;
  for (size_t i = 0; i < e.recordings.size(); ++i) {
    Recording& r = e.recordings[i];
    const double sign = i == 1 ? -1.0 : 1.0, speed = 100.0 * 0.003 / 0.02, settles = 0.002 / 0.02;  // [rad/s], [s]
    for (size_t k = 0; k < r.size(); ++k) {
      const double t = r.time[k] - r.time[0], decay = std::exp(-t / settles);
      r.joints[0].signal[0][k] = sign * speed * (t - settles * (1.0 - decay)) + 1e-4 * noise.draw();
      r.joints[0].signal[1][k] = sign * speed * (1.0 - decay) + 1e-2 * noise.draw();
      r.joints[0].signal[2][k] = sign * 100.0;
    }
  }
  return e;
}

Reports make_level_report(double level) {
  Reports reports;
  reports.report["findings"] = {{{"effect", "coulomb_friction"},
                                 {"where", {{"joint", "motor"}}},
                                 {"grade", "supported"},
                                 {"statement", ""},
                                 {"alternatives", Json::array()},
                                 {"parameters", {{"level", {{"value", level}, {"unit", "N m"}}}}}}};
  return reports;
}

TEST(UntoldUnits, FrictionThatTakesAConstantEffortMayBeItsUnit) {
  const Experiment e = make_steps("units_steps");
  Reports reports = make_level_report(99.7);
  doubt_untold_units(e, list_untold_units(make_torque_data(e), {}), &reports);
  const Json& friction = reports.report["findings"][0];
  EXPECT_EQ(friction["grade"], "ambiguous");
  ASSERT_EQ(friction["alternatives"].size(), 1u);
  EXPECT_NEAR(friction["alternatives"][0]["parameters"]["scale"].get<double>(), 0.003, 0.0003);  // a tenth, as above
}

// Along positions that a filter leaves behind, such a drive at its limit shows a direction and nothing else.
TEST(UntoldUnits, FrictionThatIsTheWholeEffortMayBeARotorThatViscousFrictionBrakes) {
  const Experiment e = make_simulated_experiment("units_whole", kDisc, {"motor"}, {});
  for (double share : {0.95, 0.5}) {
    Reports reports = make_level_report(3.0);
    reports.report["findings"][0]["share"] = share;
    doubt_untold_units(e, {EffortUnit{0}}, &reports);
    const Json& friction = reports.report["findings"][0];
    EXPECT_EQ(friction["grade"], share > 0.9 ? "ambiguous" : "supported");
    EXPECT_EQ(friction["alternatives"].size(), share > 0.9 ? 2u : 0u);
  }
}

TEST(UntoldUnits, AConstantEffortThatTheMotionOpposesMayHaveItsSignTurned) {
  Experiment e = make_steps("units_opposed");
  for (Recording& r : e.recordings) {
    for (double& y : r.joints[0].signal[2]) y = -y;
  }
  const std::optional<double> unit = find_unit_without_friction(make_torque_data(e), 0);
  ASSERT_TRUE(unit.has_value());
  EXPECT_NEAR(*unit, -0.003, 0.0003);
}

// A winch that lifts 0.5 kg, with currents of 7.2 N each: the weight is as constant as a constant force is.
TEST(UntoldUnits, AConstantForceBesideAConstantWeightMayBeTheUnit) {
  std::string lift = kDisc;
  lift.replace(lift.find("revolute"), 8, "prismatic");
  lift.replace(lift.find("mass value=\"0.1\""), 16, "mass value=\"0.5\"");
  Experiment e = make_simulated_experiment("units_lift", lift, {"motor"}, {{EffectId::kCoulomb, 0, {1.5, 0.0, 5e-4}}});
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) {
    for (double& y : r.joints[0].signal[2]) y /= 7.2;
  }
  const std::optional<double> unit = find_unit_without_constant(make_torque_data(e), 0);
  ASSERT_TRUE(unit.has_value());
  EXPECT_NEAR(*unit, 7.2, 0.4);
  EffortUnit untold;  // where a current is too noisy to show what the load's acceleration takes
  untold.joint = 0;
  untold.without_constant = *unit;
  Reports reports;
  reports.report["findings"] = {{{"effect", "constant_torque"},
                                 {"where", {{"joint", "motor"}}},
                                 {"grade", "supported"},
                                 {"statement", ""},
                                 {"alternatives", Json::array()},
                                 {"parameters", {{"torque", {{"value", -4.2}, {"unit", "N"}}}}}}};
  doubt_untold_units(e, {untold}, &reports);
  EXPECT_EQ(reports.report["findings"][0]["grade"], "ambiguous");
  EXPECT_EQ(reports.report["findings"][0]["alternatives"].size(), 1u);
}

// Friction that turns with the motion is there in any unit.
TEST(UntoldUnits, FrictionOfAMotionBackAndForthIsNoUnit) {
  Experiment e = make_simulated_experiment(
      "units_back", kDisc, {"motor"}, {{EffectId::kCoulomb, 0, {1.0, 0.0, 5e-4}}, {EffectId::kRotorInertia, 0, {0.1}}});
  e.scenario.drive = "effort";
  EXPECT_FALSE(find_unit_without_friction(make_torque_data(e), 0).has_value());
}

// What no effect explains is told in the unit of the log, too.
TEST(UntoldUnits, WhatIsMissingBesideAnUntoldUnitIsNotInNewtonMetres) {
  const Experiment e = simulate_heavy_disc("units_missing");
  Reports reports;
  reports.report["findings"] = Json::array();
  reports.report["unexplained"] = {
      {{"where", {{"joint", "motor"}}}, {"statement", "motor: about 110 N m (root mean square) are missing"}}};
  EffortUnit untold;
  untold.joint = 0;
  doubt_untold_units(e, {untold}, &reports);
  EXPECT_EQ(reports.report["unexplained"][0]["statement"],
            "motor: about 110 in the unit of the log (root mean square) are missing");
}

TEST(UntoldUnits, OfAnArmWhoseLoadsTellItNoUnitIsDoubted) {
  Experiment e = simulate_arm("units_sure", make_arm_drives());
  e.scenario.drive = "effort";
  EXPECT_TRUE(find_conventions(e, 1).untold.empty());
}

TEST(UntoldUnits, FrictionIsReportedInNewtonMetresBesideTheUnit) {
  const Experiment e = simulate_currents("units_report", make_arm_drives(), {8.0, 8.0});
  const Reports reports = diagnose_recordings(
      e, {}, [](const std::string&) {}, [](const Reports&) {});
  bool unit = false, friction = false;
  for (const Json& f : reports.report["findings"]) {
    unit = unit || (f["effect"] == "torque_constant_error" && f["where"]["joint"] == "shoulder");
    if (f["family"] != "dry friction" || f["where"]["joint"] != "shoulder" || !f["parameters"].contains("level"))
      continue;
    friction = true;
    // 15 %: as far as the unit's bracket reaches.
    EXPECT_NEAR(f["parameters"]["level"]["value"].get<double>(), 1.5, 0.15 * 1.5);
  }
  EXPECT_TRUE(unit);
  EXPECT_TRUE(friction) << reports.report["findings"].dump(1);
}

// Twice the same recordings: long enough for a first answer.
TEST(UntoldUnits, TheFirstAnswerHasThemToo) {
  Experiment e = simulate_currents("units_first", make_arm_drives(), {8.0, 8.0});
  const std::vector<Recording> once = e.recordings;
  for (Recording r : once) {
    r.spec.name = "again_" + r.spec.name;
    e.recordings.push_back(std::move(r));
  }
  // The search behind it takes half a minute: the test ends with the first answer.
  struct Enough {
    Json report;
  };
  Json first;
  try {
    diagnose_recordings(
        e, {}, [](const std::string&) {}, [](const Reports& reports) { throw Enough{reports.report}; });
  } catch (const Enough& enough) {
    first = enough.report;
  }
  ASSERT_TRUE(first.is_object());
  EXPECT_TRUE(first["preliminary"].get<bool>());
  bool unit = false;
  for (const Json& f : first["findings"])
    unit = unit || (f["effect"] == "torque_constant_error" && f["where"]["joint"] == "shoulder");
  EXPECT_TRUE(unit) << first["findings"].dump(1);
}

}  // namespace
}  // namespace hrp::diagnosis
