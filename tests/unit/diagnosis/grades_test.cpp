// SPDX-License-Identifier: BSD-3-Clause
// Grades that hold for every engine: what may not be there is never more than ambiguous.
#include <gtest/gtest.h>

#include "common/base/rounding.h"
#include "diagnosis/estimate/shapley.h"
#include "diagnosis/evidence/best_model.h"
#include "diagnosis/findings/doubtful_constants.h"
#include "diagnosis/findings/grading.h"
#include "diagnosis/findings/odd_sizes.h"
#include "diagnosis/findings/simpler_law.h"
#include "diagnosis/report/report.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

std::string lower(const std::string& effect, const Json& parameters) {
  Json report{{"findings", {{{"effect", effect}, {"grade", "supported"}, {"parameters", parameters}}}}};
  lower_grades(&report);
  return report["findings"][0]["grade"];
}

TEST(Grades, FrictionWhoseIntervalHoldsNoneIsAmbiguous) {
  EXPECT_EQ(lower("viscous_friction", {{"coefficient", {{"value", 0.1}, {"ci95", {-0.01, 0.21}}}}}), "ambiguous");
  EXPECT_EQ(lower("viscous_friction", {{"coefficient", {{"value", 0.1}, {"ci95", {0.01, 0.19}}}}}), "supported");
}

TEST(Grades, NothingIsSupportedThatPredictsHeldOutRecordingsNoBetter) {
  const Json parameters{{"coefficient", {{"value", 0.1}, {"ci95", {0.01, 0.19}}}}};
  Json report{{"explained", 0.0},
              {"findings", {{{"effect", "viscous_friction"}, {"grade", "supported"}, {"parameters", parameters}}}}};
  lower_grades(&report);
  EXPECT_EQ(report["findings"][0]["grade"], "ambiguous");
}

// A late accelerometer beside a slope that took everything was `certain`.
TEST(Grades, WhatTakesNothingAwayIsNotCertain) {
  const auto judge = [](double share) {
    Evidence evidence;
    evidence.verdict = Verdict::kExplained;
    evidence.fit.validate_before = 9.8;
    evidence.fit.validate_after = 0.7;
    evidence.findings = {make_finding(get_effect(EffectId::kSensorDelay), {{"sensor", "/imu/waist"}}, {})};
    evidence.findings[0].share = share;
    return make_graded_report(true, evidence)["findings"][0]["grade"].get<std::string>();
  };
  EXPECT_EQ(judge(0.0), "ambiguous");
  EXPECT_EQ(judge(0.2), "certain");
}

// Feet that stay show the zeros of one foot's sensor as those of the other's: the cause is known, its place is not.
TEST(Grades, WhatFitsAsWellElsewhereIsNotCertain) {
  const auto judge = [](const char* other) {
    Evidence evidence;
    evidence.verdict = Verdict::kExplained;
    evidence.fit.validate_before = 9.8;
    evidence.fit.validate_after = 0.7;
    const EffectInfo& zero = get_effect(EffectId::kSensorBias);
    evidence.findings = {make_finding(zero, {{"sensor", "/wrench/l/force"}}, {})};
    evidence.findings[0].share = 1.0;
    evidence.findings[0].alternatives.push_back(make_alternative(zero, {{"sensor", other}}, {}, ""));
    return make_graded_report(true, evidence)["findings"][0]["grade"].get<std::string>();
  };
  EXPECT_EQ(judge("/wrench/r/force"), "ambiguous");
  EXPECT_EQ(judge("/wrench/l/force"), "certain");
}

// A standing robot with one recording ended the program here, behind the search.
TEST(Grades, WithoutHeldOutRecordingsTheFittedOnesSayWhatIsExplained) {
  Evidence evidence;
  evidence.verdict = Verdict::kExplained;
  evidence.fit.train_before = 9.8;
  evidence.fit.train_after = 1.0;
  evidence.findings = {make_finding(get_effect(EffectId::kJointOffset), {{"joint", "knee"}}, {})};
  evidence.findings[0].share = 1.0;
  const Json report = make_graded_report(false, evidence);
  EXPECT_EQ(report["explained"], 1.0);
  EXPECT_EQ(report["findings"][0]["grade"], "supported");
}

// One pendulum, one recording: a gain of .69 was supported where a mass says the same in every motion.
TEST(Grades, WithoutHeldOutRecordingsTheMissingTorqueHasToSupportAFindingOfTheSimulation) {
  const auto judge = [](const char* effect, Grade of_torque) {
    Finding torque;
    torque.effect = "torque_constant_error";
    torque.where = {{"joint", "elbow"}};
    torque.grade = of_torque;
    if (of_torque == Grade::kAmbiguous)
      torque.alternatives.push_back({"mass_error", "mass", {{"link", "bob"}}, {}, ""});
    Json report{{"findings",
                 {{{"effect", effect},
                   {"grade", "supported"},
                   {"where", {{"joint", "elbow"}}},
                   {"alternatives", Json::array()}}}}};
    doubt_unconfirmed({torque}, &report);
    return report["findings"][0];
  };
  EXPECT_EQ(judge("torque_constant_error", Grade::kSupported)["grade"], "supported");
  EXPECT_EQ(judge("torque_constant_error", Grade::kAmbiguous)["grade"], "ambiguous");
  EXPECT_EQ(judge("torque_constant_error", Grade::kAmbiguous)["alternatives"][0]["effect"], "mass_error");
  EXPECT_EQ(judge("backlash", Grade::kSupported)["grade"], "ambiguous");
}

// Two sets of effects with the same hysteresis are one thing that is not told.
TEST(Grades, WhatIsNotIdentifiableIsListedOncePerPlace) {
  const auto entry = [](const char* effect, const char* joint) {
    return Json{{"effect", effect}, {"where", {{"joint", joint}}}, {"why", ""}};
  };
  Json report{{"not_identifiable",
               {entry("hysteresis", "shoulder"),
                entry("hysteresis", "elbow"),
                entry("hysteresis", "shoulder"),
                {{"effect", "restitution"}}}}};
  list_once(&report);
  EXPECT_EQ(report["not_identifiable"],
            Json({entry("hysteresis", "shoulder"), entry("hysteresis", "elbow"), {{"effect", "restitution"}}}));
}

TEST(Grades, WhereNothingIsReportedNoRivalExplainsAsMuchAsWhatIs) {
  const Experiment e = simulate_arm("grades_rivals", make_arm_drives());
  const Problem problem = make_problem(e, 1);
  Outcome outcome;
  outcome.nominal = outcome.chosen = simulate_trial(problem, {});
  outcome.mismatch = true;
  outcome.indistinguishable = {outcome.nominal};
  outcome.indistinguishable[0].hypothesis = {{EffectId::kViscous, kElbow, {0.4}}};
  const Json report = make_reports(problem, outcome).report;
  ASSERT_EQ(report["not_identifiable"].size(), 1u);
  const std::string why = report["not_identifiable"][0]["why"];
  EXPECT_EQ(why.find("as well as what is reported"), std::string::npos) << why;
}

TEST(Grades, AScaleIsAbsentAtOneAndNotAtZero) {
  EXPECT_EQ(lower("sensor_scale", {{"scale", {{"value", 1.02}, {"ci95", {0.98, 1.06}}}}}), "ambiguous");
  EXPECT_EQ(lower("sensor_scale", {{"scale", {{"value", 0.4}, {"ci95", {-0.1, 0.9}}}}}), "supported");
}

TEST(Grades, AVectorIsThereIfOneAxisIs) {
  const Json none{{"value", {0.1, 0.0, 0.0}}, {"ci95", {{-0.1, 0.3}, {-0.1, 0.1}, {-0.1, 0.1}}}};
  const Json some{{"value", {0.1, 0.0, 0.0}}, {"ci95", {{0.05, 0.15}, {-0.1, 0.1}, {-0.1, 0.1}}}};
  EXPECT_EQ(lower("sensor_bias", {{"value", none}}), "ambiguous");
  EXPECT_EQ(lower("sensor_bias", {{"value", some}}), "supported");
}

Json make_curve(double static_low, double speed_low, double viscous_low, double static_high = 0.6) {
  const auto estimate = [](double value, double low, double high) -> Json {
    return {{"value", value}, {"std", 0.0}, {"ci95", {low, high}}, {"unit", "N m"}};
  };
  Json f{{"effect", "stribeck_friction"},
         {"grade", "certain"},
         {"where", {{"joint", "elbow"}}},
         {"alternatives", Json::array()}};
  f["parameters"] = {{"coulomb", estimate(0.3, 0.28, 0.32)},
                     {"static", estimate(std::min(0.33, static_high), static_low, static_high)},
                     {"stribeck_velocity", estimate(0.012, speed_low, 0.1)},
                     {"viscous", estimate(0.01, viscous_low, 0.03)}};
  return {{"findings", {f}}};
}

// Plain dry friction of 0.3 N m in a simulation was named a Stribeck curve with these intervals, `certain`.
TEST(Grades, DryFrictionWhoseExcessAtRestIsNotToldIsCoulombs) {
  Json report = make_curve(0.06, -0.08, -0.014);
  name_simpler_laws(&report);
  ASSERT_EQ(report["findings"].size(), 1u);
  const Json& f = report["findings"][0];
  EXPECT_EQ(f["effect"], "coulomb_friction");
  EXPECT_EQ(f["grade"], "supported");
  EXPECT_EQ(f["parameters"]["level"]["value"], 0.3);
  EXPECT_EQ(f["alternatives"][0]["effect"], "stribeck_friction");
}

// A slide with 12.8 N of dry friction was named a Stribeck curve of 12.76 N, 12.81 +- 0.06 N at rest, `certain`.
TEST(Grades, DryFrictionWhoseExcessAtRestIsTooSmallToCountIsCoulombs) {
  Json report = make_curve(0.29, 0.002, 0.005, 0.31);
  name_simpler_laws(&report);
  ASSERT_EQ(report["findings"].size(), 2u);
  EXPECT_EQ(report["findings"][0]["effect"], "coulomb_friction");
  EXPECT_EQ(report["findings"][0]["grade"], "certain");
  EXPECT_EQ(report["findings"][1]["effect"], "viscous_friction");
  EXPECT_EQ(report["findings"][1]["grade"], "supported");
}

TEST(Grades, ViscousFrictionThatIsToldIsNamedBesideCoulombs) {
  Json report = make_curve(0.06, -0.08, 0.005);
  name_simpler_laws(&report);
  ASSERT_EQ(report["findings"].size(), 2u);
  EXPECT_EQ(report["findings"][1]["effect"], "viscous_friction");
}

TEST(Grades, AStribeckCurveWithAToldExcessOrSpeedStays) {
  for (const auto& [excess, speed] : {std::pair{0.32, -0.08}, std::pair{0.06, 0.002}}) {
    Json report = make_curve(excess, speed, -0.014);
    name_simpler_laws(&report);
    EXPECT_EQ(report["findings"][0]["effect"], "stribeck_friction");
    EXPECT_EQ(report["findings"][0]["grade"], "certain");
  }
}

Json make_hardening_sole(double angle, double reach) {
  const auto estimate = [](double value, double half) -> Json {
    return {{"value", value}, {"ci95", {value - half, value + half}}, {"unit", "rad"}};
  };
  Json f{{"effect", "foot_hardening"},
         {"grade", "supported"},
         {"where", {{"foot", "l_foot"}}},
         {"alternatives", Json::array()}};
  f["parameters"] = {{"k_roll", estimate(330, 7)}, {"hardening_angle", estimate(angle, reach)}};
  return {{"findings", {f}}};
}

// 1 / angle^2 is 2.9 +- 68 of one sole, and 400 +- 40 of the other.
TEST(Grades, ASoleWhoseHardeningIsNotToldGivesLinearly) {
  Json untold = make_hardening_sole(2.93, 34), told = make_hardening_sole(0.05, 0.0025);
  name_simpler_laws(&untold);
  name_simpler_laws(&told);
  EXPECT_EQ(untold["findings"][0]["effect"], "foot_compliance");
  EXPECT_FALSE(untold["findings"][0]["parameters"].contains("hardening_angle"));
  EXPECT_EQ(untold["findings"][0]["alternatives"][0]["effect"], "foot_hardening");
  EXPECT_EQ(told["findings"][0]["effect"], "foot_hardening");
}

// One link of 2 kg whose centre of mass is 0.1 m from its joint: it reaches 0.3 m, three times its weight are 59 N.
TreeSpec make_pendulum() {
  TreeSpec tree;
  LinkSpec bob;
  bob.name = "bob";
  bob.inertia.mass = 2.0;
  bob.inertia.p_LLcm_L = Vector3d(0.1, 0.0, 0.0);
  tree.links.push_back(bob);
  return tree;
}

Json make_finding(const char* effect, const char* kind, const char* name, const char* parameter, const Json& value) {
  return {{"effect", effect},
          {"grade", "certain"},
          {"where", {{kind, name}}},
          {"statement", "It is so."},
          {"parameters",
           {{parameter, {{"value", value}, {"std", value.is_number() ? Json(0.01) : Json{0.01, 0.01, 0.01}}}}}}};
}

TEST(OddSizes, ACentreOfMassOutsideItsLinkIsOdd) {
  const TreeSpec tree = make_pendulum();
  EXPECT_EQ(find_odd_size(tree, make_finding("com_error", "link", "bob", "offset", {0.0, 0.0, 0.29})), "");
  EXPECT_NE(find_odd_size(tree, make_finding("com_error", "link", "bob", "offset", {0.0, 0.0, 0.31})), "");
  EXPECT_EQ(find_odd_size(tree, make_finding("payload", "link", "bob", "com", {0.0, 0.0, 0.7})), "");
}

TEST(OddSizes, AForceOfMoreThanThreeWeightsIsOdd) {
  const TreeSpec tree = make_pendulum();
  EXPECT_EQ(find_odd_size(tree, make_finding("external_force", "link", "bob", "force", {0.0, 58.0, 0.0})), "");
  EXPECT_NE(find_odd_size(tree, make_finding("external_force", "link", "bob", "force", {0.0, 60.0, 0.0})), "");
}

TEST(OddSizes, ATorqueConstantMayBeHalfButNotAFifthAndASensorMayCount) {
  const TreeSpec tree = make_pendulum();
  EXPECT_EQ(find_odd_size(tree, make_finding("torque_constant_error", "joint", "elbow", "scale", 0.5)), "");
  EXPECT_NE(find_odd_size(tree, make_finding("torque_constant_error", "joint", "elbow", "scale", 0.2)), "");
  EXPECT_EQ(find_odd_size(tree, make_finding("sensor_scale", "sensor", "/wrench/foot", "scale", 11.8)), "");
}

// A pendulum that turns by half a turn either way.
TEST(OddSizes, ASpringThatIsWoundUpByMoreThanATurnIsOdd) {
  TreeSpec tree = make_pendulum();
  LinkSpec& bob = tree.links[0];
  bob.joint.name = "elbow";
  bob.joint.kind = JointKind::kRevolute;
  bob.joint.lower = -M_PI;
  bob.joint.upper = M_PI;
  EXPECT_EQ(find_odd_size(tree, make_finding("parallel_spring", "joint", "elbow", "rest", -9.0)), "");
  EXPECT_NE(find_odd_size(tree, make_finding("parallel_spring", "joint", "elbow", "rest", -13.0)), "");
  EXPECT_NE(find_odd_size(tree, make_finding("parallel_spring", "joint", "elbow", "rest", 9.5)), "");
}

// A load of 152 kg less than a millimetre from an axis has the weight of what is missing.
TEST(OddSizes, WhatIsHardlyPossibleIsNoAlternative) {
  Json finding = make_finding("com_error", "link", "bob", "offset", {0.0, 0.0, 0.1});
  finding["alternatives"] = {make_finding("payload", "link", "bob", "mass", 152.0),
                             make_finding("payload", "link", "bob", "mass", 0.2)};
  Json report{{"verdict", "mostly_explained"}, {"findings", {finding}}};
  doubt_odd_sizes(make_pendulum(), &report);
  ASSERT_EQ(report["findings"][0]["alternatives"].size(), 1u);
  EXPECT_EQ(report["findings"][0]["alternatives"][0]["parameters"]["mass"]["value"], 0.2);
}

TEST(OddSizes, WhatIsCertainBesideAnOddSizeIsNotCertain) {
  Json report{{"verdict", "explained"},
              {"findings",
               {make_finding("parallel_spring", "joint", "elbow", "stiffness", 80.0),
                make_finding("external_force", "link", "bob", "force", {698.0, 0.0, 0.0})}}};
  doubt_odd_sizes(make_pendulum(), &report);
  EXPECT_EQ(report["findings"][0]["grade"], "ambiguous");
  EXPECT_EQ(report["findings"][1]["grade"], "ambiguous");
  EXPECT_EQ(report["verdict"], "mostly_explained");
}

// A robot of 50 kg: 245 N sink by 0.44 mm on 5.6e5 N/m, by 2.5 mm on 1e5 N/m.
TEST(StiffSoles, AGiveOfLessThanAMillimetreMayBeTheFloors) {
  TreeSpec tree = make_pendulum();
  tree.links[0].inertia.mass = 50.0;
  const auto judge = [&](double kz, double k_roll) {
    Json sole = make_finding("foot_compliance", "foot", "left", "kz", kz);
    sole["parameters"]["k_roll"] = {{"value", k_roll}};
    Json report{{"findings", {sole}}};
    doubt_stiff_soles(tree, &report);
    return report["findings"][0]["grade"].get<std::string>();
  };
  EXPECT_EQ(judge(5.6e5, 15000.0), "ambiguous");
  EXPECT_EQ(judge(1.0e5, 15000.0), "certain");
  EXPECT_EQ(judge(5.6e5, 300.0), "certain");
}

// Two effects of which each alone takes away 0.6, and both 0.8, take 0.4 each; one that does nothing takes nothing.
TEST(Shares, OfEffectsThatStandInForOneAnotherAreEqualAndSumToTheWhole) {
  const auto value = [](size_t mask) { return (mask & 3) == 3 ? 0.8 : (mask & 3) ? 0.6 : 0.0; };
  const std::vector<double> shares = calc_shapley(3, value);
  EXPECT_NEAR(shares[0], 0.4, 1e-12);
  EXPECT_NEAR(shares[1], 0.4, 1e-12);
  EXPECT_NEAR(shares[2], 0.0, 1e-12);
  EXPECT_NEAR(calc_shapley(3, value, 2)[0], 0.2, 1e-12) << "beyond the limit: what is lost without it";
}

TEST(IdleFindings, ARotorOfATenthOfItsSpreadSaysNothingBesideAnother) {
  Json rotor = make_finding("rotor_inertia", "joint", "elbow", "inertia", 0.001);
  rotor["grade"] = "ambiguous";
  Json report{{"findings", {make_finding("backlash", "joint", "elbow", "gap", 0.02), rotor}}};
  drop_idle_findings(&report);
  ASSERT_EQ(report["findings"].size(), 1u);
  EXPECT_EQ(report["findings"][0]["effect"], "backlash");
}

// A knee's rotor of 0.0007 +- 0.0009 kg m^2 beside two soles that explain a walk to its noise.
TEST(IdleFindings, WhatMayBeNoneIsNotNamedWhereTheRestExplainsAllAndIsNamedWhereItDoesNot) {
  const auto count = [](const char* verdict) {
    Json rotor = make_finding("rotor_inertia", "joint", "elbow", "inertia", 0.001);
    rotor["grade"] = "ambiguous";
    Json& inertia = rotor["parameters"]["inertia"];
    inertia["std"] = 0.7 * inertia["value"].get<double>();
    inertia["ci95"] = {-0.4 * inertia["value"].get<double>(), 2.4 * inertia["value"].get<double>()};
    Json report{{"verdict", verdict}, {"findings", {make_finding("backlash", "joint", "elbow", "gap", 0.02), rotor}}};
    drop_idle_findings(&report);
    return report["findings"].size();
  };
  EXPECT_EQ(count("explained"), 1u);
  EXPECT_EQ(count("mostly_explained"), 2u) << "a real drive has a rotor, however little is known of it";
}

// Play of 17 mrad in an ankle came out as play of 9 mrad beside a zero of 4 mrad, each listed as the other.
TEST(IdleFindings, ALighterFindingThatIsAnAlternativeOfOneAtItsPlaceIsNotNamedASecondTime) {
  const auto list_effects = [](const char* place_of_zero) {
    Json play = make_finding("backlash", "joint", "ankle", "gap", 0.009);
    Json zero = make_finding("joint_offset", "joint", place_of_zero, "offset", 0.004);
    for (Json* f : {&play, &zero}) (*f)["grade"] = "ambiguous";
    play["weight"] = 0.3;
    zero["weight"] = 0.1;
    play["alternatives"] = {state_as_alternative(zero)};
    zero["alternatives"] = {state_as_alternative(play)};
    Json report{{"verdict", "explained"}, {"findings", {zero, play}}};
    drop_idle_findings(&report);
    return report["findings"];
  };
  ASSERT_EQ(list_effects("ankle").size(), 1u);
  EXPECT_EQ(list_effects("ankle")[0]["effect"], "backlash");
  EXPECT_EQ(list_effects("knee").size(), 2u);
}

TEST(Numbers, AHundredWithTwoDigitsIsPrintedAsPeopleWriteIt) {
  EXPECT_EQ(number(100.0, 2), "100");
  EXPECT_EQ(number(1234.0, 2), "1200");
  EXPECT_EQ(number(0.01234, 2), "0.012");
  EXPECT_EQ(number(1.2e6, 2), "1.2e+06");
}

// A torso's mass that is not where the model has it, or a sensor's zero: until that is told, a constant torque of the
// waist may be its weight.
TEST(DoubtfulConstants, OfARobotOnItsFeetMayBeTheWeightOfAMisplacedMass) {
  const Json torso{{"effect", "com_error"},
                   {"family", "mass and its place"},
                   {"where", {{"link", "torso"}}},
                   {"parameters", Json::object()}};
  const auto grade_constant = [&](bool on_feet, const char* grade_of_zero) {
    Experiment e;
    e.scenario.floating_base = on_feet;
    Json report;
    // The torso stands twice among what the other finding may be.
    report["findings"] = {{{"effect", "sensor_bias"}, {"grade", grade_of_zero}, {"alternatives", {torso, torso}}},
                          {{"effect", "constant_torque"},
                           {"grade", "supported"},
                           {"where", {{"joint", "waist"}}},
                           {"alternatives", Json::array()}},
                          {{"effect", "joint_offset"},
                           {"grade", "supported"},
                           {"where", {{"joint", "waist"}}},
                           {"alternatives", Json::array()}}};
    doubt_constants_of_masses(e, &report);
    EXPECT_EQ(report["findings"][2]["grade"], "supported");
    return report["findings"][1];
  };
  const Json constant = grade_constant(true, "ambiguous");
  EXPECT_EQ(constant["grade"], "ambiguous");
  ASSERT_EQ(constant["alternatives"].size(), 1u);
  EXPECT_EQ(constant["alternatives"][0], torso);
  EXPECT_EQ(grade_constant(true, "supported")["grade"], "supported");
  EXPECT_EQ(grade_constant(false, "ambiguous")["grade"], "supported");
}

// Both cancel: the zero of the commands explains them with one number.
TEST(DoubtfulConstants, AZeroOfAnEffortThatAConstantTorqueCancelsMayBeThatOfTheCommands) {
  const Experiment e = make_simulated_experiment("doubtful_commands", kArm, kArmJoints, {});
  const auto grade = [&](double torque) {
    Json report;
    const auto state = [](double value) { return Json{{"value", value}, {"std", 0.3}, {"unit", "N m"}}; };
    report["findings"] = {{{"effect", "sensor_bias"},
                           {"family", "zero"},
                           {"grade", "supported"},
                           {"where", {{"sensor", "/joint_states/shoulder/effort"}}},
                           {"parameters", {{"value", state(4.0)}}},
                           {"alternatives", Json::array()}},
                          {{"effect", "constant_torque"},
                           {"family", "zero"},
                           {"grade", "supported"},
                           {"where", {{"joint", "shoulder"}}},
                           {"parameters", {{"torque", state(torque)}}},
                           {"alternatives", Json::array()}}};
    doubt_constants_of_commands(e, &report);
    EXPECT_EQ(report["findings"][0]["grade"], report["findings"][1]["grade"]);
    return report["findings"][1]["grade"].get<std::string>();
  };
  EXPECT_EQ(grade(-3.6), "ambiguous");
  EXPECT_EQ(grade(-1.0), "supported");
  EXPECT_EQ(grade(3.6), "supported");
}

// Torque of a joint that sticks ends where its friction does.
TEST(OddSizes, ALimitOfTheDriveWithinTheJointsOwnFrictionMayBeThatFriction) {
  const auto grade_limit = [](double limit, const char* unit, double most_friction) {
    Json report;
    report["findings"] = {
        {{"effect", "coulomb_friction"},
         {"family", "dry friction"},
         {"grade", "supported"},
         {"where", {{"joint", "waist"}}},
         {"parameters", {{"level", {{"value", 4.2}, {"ci95", {3.4, most_friction}}, {"unit", "N m"}}}}}},
        {{"effect", "torque_saturation"},
         {"family", "limits"},
         {"grade", "supported"},
         {"where", {{"joint", "waist"}}},
         {"parameters", {{"limit", {{"value", limit}, {"ci95", {limit - 0.1, limit + 0.1}}, {"unit", unit}}}}},
         {"alternatives", Json::array()}}};
    doubt_limits_within_friction(&report);
    return report["findings"][1]["grade"].get<std::string>();
  };
  EXPECT_EQ(grade_limit(4.3, "N m", 5.1), "ambiguous");
  EXPECT_EQ(grade_limit(12.0, "N m", 5.1), "supported");
  EXPECT_EQ(grade_limit(4.3, "rad/s", 5.1), "supported");  // of the speed
}

}  // namespace
}  // namespace hrp::diagnosis
