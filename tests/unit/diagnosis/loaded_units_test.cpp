// SPDX-License-Identifier: BSD-3-Clause
// Currents of an arm that carries a tool and has a spring: the units of all joints and the tool are told together.
#include <gtest/gtest.h>

#include <algorithm>

#include "common/effects/effect_info.h"
#include "diagnosis/conventions/effort_units.h"
#include "diagnosis/conventions/loaded_units.h"
#include "diagnosis/conventions/log_conventions.h"
#include "diagnosis/conventions/unit_doubts.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

const std::vector<double> kTorqueOfUnit{40.0, 25.0};

Experiment make_amperes(const std::string& name, const Hypothesis& beside) {
  Hypothesis hidden = make_arm_drives();
  hidden.insert(hidden.end(), beside.begin(), beside.end());
  return simulate_currents(name, hidden, kTorqueOfUnit);
}

const Effect kTool{EffectId::kPayload, kFore, {0.8, 0.3, 0.0, 0.0, 0.0}};

// Two joints that move in one plane: a smaller tool with smaller units does as well as the tool.
TEST(LoadedUnits, WhereUnitsStandForAToolTheyAreAmbiguousAndNameIt) {
  const Experiment e = make_amperes("loaded_tool", {kTool});
  const std::vector<EffortUnit> units = find_effort_units(make_torque_data(e));
  ASSERT_EQ(units.size(), 2u);
  for (const EffortUnit& u : units) {
    const bool right = std::abs(std::log(u.scale / kTorqueOfUnit[static_cast<size_t>(u.joint)])) < 0.1;
    EXPECT_TRUE(right || is_load_or_unit(u)) << u.joint << ": " << u.scale << " " << u.by_load;
  }
}

TEST(LoadedUnits, ASpringMovesNoUnit) {
  const Experiment e = make_amperes("loaded_spring", {{EffectId::kSpring, kShoulder, {8.0, 0.0}}});
  const std::vector<EffortUnit> units = find_effort_units(make_torque_data(e));
  ASSERT_EQ(units.size(), 2u);
  for (const EffortUnit& u : units)
    EXPECT_NEAR(u.scale / kTorqueOfUnit[static_cast<size_t>(u.joint)], 1.0, 0.1) << u.joint;  // as above
}

// Swings about the hanging arm: weight and inertia grow with the angle, as the torque of a spring does. What they leave
// of the torque is less than a forearm that is lighter than its model changes.
TEST(LoadedUnits, AUnitThatASpringLeavesASmallPartOfTheTorqueForIsNotTold) {
  std::string hanging = kArm;
  hanging.replace(hanging.find("<axis"), 0, "<origin rpy=\"0 1.5707963 0\"/>");
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kSpring, kShoulder, {8.0, 0.0}});
  hidden.push_back({EffectId::kMassError, kFore, {0.8}});
  for (const EffortUnit& u :
       find_effort_units(make_torque_data(simulate_currents("loaded_hanging", hanging, hidden, kTorqueOfUnit))))
    EXPECT_EQ(u.by_others, u.joint == kShoulder) << u.joint << ": " << u.scale;
}

TEST(LoadedUnits, WithoutALoadNoneIsFound) {
  const Experiment e = make_amperes("loaded_none", {});
  EXPECT_LT(find_loaded_units(make_torque_data(e), {kShoulder, kElbow}).link, 0);
}

Json make_payload() {
  return {{"effect", "payload"},
          {"grade", "supported"},
          {"where", {{"link", "fore"}}},
          {"statement", "fore: 2 kg."},
          {"parameters", {{"mass", {{"value", 2.0}, {"std", 0.1}, {"ci95", {1.8, 2.2}}, {"unit", "kg"}}}}},
          {"alternatives", Json::array()}};
}

// The mass of what it carries is in the units' hands: if the motion tells no load beside them, none is supported.
TEST(LoadedUnits, AMassThatUnitsMayStandForIsAmbiguousAndNamesThem) {
  const Experiment e = make_amperes("loaded_doubt", {});
  EffortUnit unit;
  unit.joint = kElbow;
  unit.scale = 5.0;
  unit.low = 4.8;
  unit.high = 5.2;
  Reports reports;
  reports.report["findings"] = Json::array({make_payload()});
  doubt_beside_units(e, {unit}, &reports);
  const Json& doubted = reports.report["findings"][0];
  EXPECT_EQ(doubted["grade"], "ambiguous");
  ASSERT_EQ(doubted["alternatives"].size(), 1u);
  EXPECT_EQ(doubted["alternatives"][0]["effect"], "torque_constant_error");
  EXPECT_EQ(doubted["alternatives"][0]["where"]["joint"], "elbow");
}

TEST(LoadedUnits, AMassThatIsToldBesideUnitsKeepsItsGradeWithAWiderInterval) {
  const Experiment e = make_amperes("loaded_told", {});
  EffortUnit unit;
  unit.joint = kElbow;
  unit.scale = 5.0;
  unit.low = 4.8;
  unit.high = 5.2;
  unit.of_load = 0.1;
  Reports reports;
  reports.report["findings"] = Json::array({make_payload()});
  doubt_beside_units(e, {unit}, &reports);
  const Json& kept = reports.report["findings"][0];
  EXPECT_EQ(kept["grade"], "supported");
  EXPECT_NEAR(kept["parameters"]["mass"]["std"].get<double>(), std::hypot(0.1, 0.2), 1e-9);
  EXPECT_LT(kept["parameters"]["mass"]["ci95"][0].get<double>(), 1.8);
}

Json make_of_joint(const char* effect, const char* parameter, double value, const char* unit) {
  return {{"effect", effect},
          {"grade", "supported"},
          {"where", {{"joint", "elbow"}}},
          {"statement", "elbow."},
          {"parameters",
           {{parameter, {{"value", value}, {"std", 0.01}, {"ci95", {value - 0.02, value + 0.02}}, {"unit", unit}}}}},
          {"alternatives", Json::array()}};
}

// Inertia of bodies in a wrong unit looks like a rotor. Nothing of bodies looks like friction.
TEST(UnitDoubts, FrictionIsThereInAnyUnitAndARotorMayBeNone) {
  const Experiment e = make_amperes("loaded_friction", {});
  EffortUnit unit;
  unit.joint = kElbow;
  unit.scale = 5.0;
  unit.low = 4.8;
  unit.high = 5.2;
  unit.by_load = 0.3;  // or another load and unit
  Reports reports;
  reports.report["findings"] = Json::array({make_of_joint("coulomb_friction", "level", 1.0, "N m"),
                                            make_of_joint("rotor_inertia", "inertia", 0.2, "kg m^2")});
  doubt_beside_units(e, {unit}, &reports);
  const Json &friction = reports.report["findings"][0], &rotor = reports.report["findings"][1];
  EXPECT_EQ(friction["grade"], "supported");
  EXPECT_LT(friction["parameters"]["level"]["ci95"][0].get<double>(), 0.45);  // 1 - 1.96 x 0.3 = 0.41
  EXPECT_EQ(rotor["grade"], "ambiguous");
  unit.by_load = 0.6;  // the interval holds none
  reports.report["findings"] = Json::array({make_of_joint("coulomb_friction", "level", 1.0, "N m")});
  doubt_beside_units(e, {unit}, &reports);
  EXPECT_EQ(reports.report["findings"][0]["grade"], "ambiguous");
}

// Masses that are a few per cent off look like a load of 0.1 +- 0.4 kg, which is a twentieth of the torque at most.
TEST(UnitDoubts, ALoadThatIsHardlyToldBlursNoTorqueThatItIsASmallPartOf) {
  const Experiment e = make_amperes("loaded_little", {});
  EffortUnit unit;
  unit.joint = kElbow;
  unit.scale = 5.0;
  unit.low = 4.8;
  unit.high = 5.2;
  unit.of_load = 1.9;
  unit.by_load = 0.1;
  EXPECT_FALSE(is_load_or_unit(unit));
  Reports reports;
  reports.report["findings"] = Json::array({make_of_joint("rotor_inertia", "inertia", 0.2, "kg m^2"), make_payload()});
  doubt_beside_units(e, {unit}, &reports);
  EXPECT_EQ(reports.report["findings"][0]["grade"], "supported");
  EXPECT_GT(reports.report["findings"][0]["parameters"]["inertia"]["ci95"][0].get<double>(), 0.17);
  EXPECT_EQ(reports.report["findings"][1]["grade"], "ambiguous");
}

Json make_load_friction(double ratio) {
  return {{"effect", "backdriving_friction"},
          {"grade", "supported"},
          {"where", {{"joint", "elbow"}}},
          {"statement", "elbow."},
          {"parameters",
           {{"ratio", {{"value", ratio}, {"std", 0.03}, {"ci95", {ratio - 0.06, ratio + 0.06}}, {"unit", "1"}}}}},
          {"alternatives", Json::array()}};
}

// A unit of 5 that may be 6.5: a third of the load's torque may be the unit's error.
TEST(UnitDoubts, FrictionThatGrowsWithTheLoadIsNoSurerThanTheUnitOfTheEffort) {
  const Experiment e = make_amperes("loaded_share", {});
  EffortUnit unit;
  unit.joint = kElbow;
  unit.scale = 5.0;
  unit.low = 3.8;
  unit.high = 6.5;
  unit.of_load = 0.1;
  Reports reports;
  reports.report["findings"] = Json::array({make_load_friction(0.3), make_load_friction(0.9)});
  doubt_beside_units(e, {unit}, &reports);
  EXPECT_EQ(reports.report["findings"][0]["grade"], "ambiguous");
  EXPECT_EQ(reports.report["findings"][0]["alternatives"][0]["effect"], "torque_constant_error");
  EXPECT_EQ(reports.report["findings"][1]["grade"], "supported");
  EXPECT_LT(reports.report["findings"][1]["parameters"]["ratio"]["ci95"][0].get<double>(), 0.7);
}

// A wrist that carries little but the load takes another unit for another lever of it.
TEST(LoadedUnits, APlaceThatMomentsInFittedUnitsTellIsAmbiguousWithAWiderInterval) {
  const Experiment e = make_amperes("loaded_place", {});
  EffortUnit unit;
  unit.joint = kElbow;
  unit.scale = 5.0;
  unit.low = 4.8;
  unit.high = 5.2;
  unit.of_load = 0.1;
  Json payload = make_payload();
  payload["parameters"]["com"] = {{"value", {0.1, 0.0, 0.0}},
                                  {"std", {0.001, 0.001, 0.001}},
                                  {"ci95", {{0.098, 0.102}, {-0.002, 0.002}, {-0.002, 0.002}}},
                                  {"unit", "m"}};
  Reports reports;
  reports.report["findings"] = Json::array({payload});
  doubt_beside_units(e, {unit}, &reports);
  const Json& doubted = reports.report["findings"][0];
  EXPECT_EQ(doubted["grade"], "ambiguous");
  EXPECT_EQ(doubted["alternatives"][0]["effect"], "torque_constant_error");
  EXPECT_GT(doubted["parameters"]["com"]["std"][0].get<double>(), 0.1 * 0.1);  // at least that of the load's mass
}

Json make_force(const std::vector<double>& low, const std::vector<double>& high) {
  Json ends = Json::array();
  for (size_t i = 0; i < 3; ++i) ends.push_back({low[i], high[i]});
  return {{"effect", "external_force"},
          {"grade", "supported"},
          {"where", {{"link", "fore"}}},
          {"statement", "fore: a constant force."},
          {"parameters",
           {{"force", {{"value", {0.0, 0.0, 6.0}}, {"std", {0.5, 0.0, 0.5}}, {"ci95", ends}, {"unit", "N"}}}}},
          {"alternatives", Json::array()}};
}

std::string grade_force(const Experiment& e, const Json& force) {
  Json report;
  report["findings"] = Json::array({force});
  doubt_upright_forces(e, &report);
  return report["findings"][0]["grade"];
}

// Half the weight of the arm is carried by nobody, or the servo is half as stiff as stated.
TEST(UprightForces, WithoutLoggedEffortsAForceAlongGravityMayBeAWrongGain) {
  Experiment e = simulate_arm("upright", {});
  const Json upright = make_force({-1.0, 0.0, 5.0}, {0.8, 0.0, 7.0}),
             slanted = make_force({2.0, 0.0, 5.0}, {4.0, 0.0, 7.0});
  EXPECT_EQ(grade_force(e, upright), "supported");  // efforts were logged
  for (Recording& r : e.recordings) {
    for (JointColumns& joint : r.joints) joint.signal[2].clear();
  }
  EXPECT_EQ(grade_force(e, upright), "ambiguous");
  EXPECT_EQ(grade_force(e, slanted), "supported");  // no gain pulls sideways
}

}  // namespace
}  // namespace hrp::diagnosis
