// SPDX-License-Identifier: BSD-3-Clause
// What the report says first, on the page and on the terminal.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "diagnosis/page/headline.h"
#include "diagnosis/page/lead.h"
#include "diagnosis/page/terminal.h"

namespace hrp::diagnosis {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

json make_finding(const char* effect, const char* joint, const char* grade, const char* parameter, double value,
                  double half, const char* unit) {
  return {{"effect", effect},
          {"where", {{"joint", joint}}},
          {"grade", grade},
          {"share", 0.5},
          {"weight", 0.1},
          {"statement", std::string(joint) + " lacks it."},
          {"parameters", {{parameter, {{"value", value}, {"ci95", {value - half, value + half}}, {"unit", unit}}}}},
          {"alternatives", json::array()}};
}

// A leg of four joints: dry friction in all, one of it weak; one bus that is late for all.
json make_leg() {
  json report{{"verdict", "mostly_explained"},
              {"findings", json::array()},
              {"unexplained", json::array()},
              {"ceiling", 0.5},
              {"explained", 0.45},
              {"remaining", json::array()}};
  const char* const joints[] = {"hip", "thigh", "knee", "ankle"};
  const double levels[] = {0.2, 0.3, 1.1, 0.1};
  for (int j = 0; j < 4; ++j)
    report["findings"].push_back(make_finding("coulomb_friction", joints[j], j == 3 ? "ambiguous" : "supported",
                                              "level", levels[j], 0.05, "N m"));
  for (const char* joint : joints)
    report["findings"].push_back(make_finding("command_delay", joint, "ambiguous", "delay", 0.008, 0.002, "s"));
  report["fit"] = {{"held_out", true},
                   {"per_signal",
                    {{"/joint_states/hip/position", {{"rms_before", 0.03}, {"rms_after", 0.003}, {"unit", "rad"}}},
                     {"/joint_states/knee/position", {{"rms_before", 0.04}, {"rms_after", 0.004}, {"unit", "rad"}}}}}};
  report["remaining"].push_back({{"share", 0.1}, {"statement", "little"}});
  return report;
}

std::string join(const json& report) { return make_summary_text(report); }

TEST(Headline, FrictionOfManyJointsIsOneSentenceWithItsRangeAndTheWorstJoint) {
  EXPECT_THAT(join(make_leg()),
              HasSubstr("Coulomb friction at joints hip, thigh and knee: level 0.2 to 1.1 N m, most at joint knee; "
                        "perhaps also at joint ankle: level 0.1 ± 0.05 N m."));
}

TEST(Headline, RecordingsThatAreTooShortAreNamedWhereNothingWasFound) {
  json report{
      {"verdict", "unexplained"},
      {"findings", json::array()},
      {"unexplained", json::array()},
      {"warnings",
       {"a.csv: lasts 0.2 s (50 samples): too short to show what a model leaves out; expected seconds of motion"}}};
  EXPECT_THAT(join(report), HasSubstr("too short to show what a model leaves out: a.csv. Record seconds of motion."));
  report["warnings"].clear();
  EXPECT_THAT(join(report), Not(HasSubstr("too short")));
}

// A servo whose friction and late commands take most of the error only together.
TEST(Headline, EffectsThatWereJudgedAsASetAreOneSentenceWithTheErrorThatTheyTakeAway) {
  json report = make_leg();
  report["as_set"] = true;
  report["findings"] = {make_finding("viscous_friction", "hip", "ambiguous", "coefficient", 0.85, 0.1, "N m s/rad"),
                        make_finding("command_delay", "hip", "ambiguous", "delay", 0.097, 0.007, "s")};
  EXPECT_THAT(
      join(report),
      testing::StartsWith(
          "With viscous friction at joint hip (coefficient 0.85 ± 0.1 N m s/rad) and command delay at joint hip "
          "(delay 0.097 ± 0.007 s), held-out errors fall: positions from 0.0354 to 0.00354 rad."));
}

// Nothing is a finding, and yet whoever reads knows what to try first, with which value.
TEST(Headline, WhereNothingIsExplainedTheEffectsThatComeClosestLead) {
  json report = make_leg();
  report["findings"] = json::array();
  report["verdict"] = "unexplained";
  report["closest"] = {
      {"effects", {make_finding("viscous_friction", "hip", "ambiguous", "coefficient", 0.85, 0.1, "N m s/rad")}},
      {"others", {"command_delay@hip"}},
      {"times_noise", {{"before", 116.0}, {"after", 12.0}}}};
  EXPECT_THAT(
      join(report),
      testing::StartsWith(
          "Viscous friction at joint hip (coefficient 0.85 ± 0.1 N m s/rad) comes closest: the held-out error falls "
          "from 116 to 12 times the noise. What is left has another cause, so it is no finding. About as close: "
          "command_delay@hip."));
}

TEST(Headline, ForcesOfARailAndTorquesOfJointsAreToldApart) {
  json report = make_leg();
  report["findings"].push_back(make_finding("coulomb_friction", "rail", "supported", "level", 178.0, 30.0, "N"));
  report["findings"].push_back(make_finding("coulomb_friction", "waist", "supported", "level", 379.0, 50.0, "N m"));
  const std::string text = join(report);
  EXPECT_THAT(text, HasSubstr("Coulomb friction at joint rail: level 178 ± 30 N, and at 4 joints: level 0.2 to 380 N "
                              "m, most at joint waist"));
}

// Of 290 mA nobody knows whether they are more than 3 N m.
TEST(Headline, ValuesInTheUnitOfALogAreNotComparedWithNewtonMetres) {
  json report = make_leg();
  json wrist = make_finding("coulomb_friction", "wrist", "supported", "level", 290.0, 20.0, "N m");
  wrist["in_log_unit"] = true;
  report["findings"].push_back(wrist);
  report["untold_units"] = {"wrist"};
  json unit = make_finding("torque_constant_error", "hip", "supported", "scale", 0.014, 0.001, "1");
  unit["of_log"] = true;
  report["findings"].push_back(unit);
  report["fit"]["per_signal"] = {
      {"/joint_states/hip/effort", {{"rms_before", 3.0}, {"rms_after", 1.0}, {"unit", "N m"}}},
      {"/joint_states/wrist/effort", {{"rms_before", 400.0}, {"rms_after", 40.0}, {"unit", "N m"}}}};
  const std::string text = join(report);
  EXPECT_THAT(
      text,
      HasSubstr("level 0.2 to 1.1 N m, most at joint knee, and at joint wrist: level 290 ± 20 N m (unit of the log)"));
  EXPECT_THAT(text, HasSubstr("efforts from 3 to 1 N m"));
}

TEST(Headline, FeetThatLogCountsAreSaidSoApartFromAScaleThatIsOff) {
  json report = make_leg();
  const auto add = [&](const char* sensor, double value, const char* unit) {
    report["findings"].push_back(make_finding("sensor_scale", "knee", "supported", "scale", value, 0.1, unit));
    report["findings"].back()["where"] = {{"sensor", sensor}};
  };
  add("/wrench/left/force", 8.4, "counts/N");
  add("/wrench/right/force", 9.9, "counts/N");
  add("/imu/base/linear_acceleration", 0.98, "1");
  const std::string text = join(report);
  EXPECT_THAT(text, HasSubstr("Forces are raw counts, no newtons, at sensors /wrench/left/force and "
                              "/wrench/right/force: scale 8.4 to 9.9 counts/N"));
  EXPECT_THAT(text, HasSubstr("Sensor scale at sensor /imu/base/linear_acceleration: scale 0.98"));
}

TEST(Headline, WhatIsOnlyAmbiguousIsSaidAsPerhaps) {
  EXPECT_THAT(join(make_leg()), HasSubstr("Perhaps command delay at 4 joints: delay 0.008 ± 0.002 s at each."));
}

TEST(Headline, WhatIsSureStandsBeforeWhatIsPerhapsThereAndFaultsOfALogLast) {
  json report = make_leg();
  json foot = make_finding("foot_compliance", "knee", "supported", "kz", 1900.0, 300.0, "N/m");
  foot["where"] = {{"foot", "sole"}};
  foot["weight"] = 0.0;
  json late = make_finding("sensor_delay", "knee", "supported", "delay", 0.02, 0.001, "s");
  late["where"] = {{"sensor", "/joint_states/knee/velocity"}};
  late["weight"] = 0.0;
  report["findings"].push_back(foot);
  report["findings"].push_back(late);
  const std::string text = join(report);
  EXPECT_LT(text.find("Coulomb friction"), text.find("Foot compliance"));
  EXPECT_LT(text.find("Foot compliance"), text.find("Perhaps command delay"));
  EXPECT_LT(text.find("Perhaps command delay"), text.find("ensor delay"));
}

TEST(Headline, ErrorsStandInRadiansAsRootMeanSquaresOverJoints) {
  // sqrt((0.03^2 + 0.04^2) / 2) = 0.03536.
  EXPECT_THAT(join(make_leg()), HasSubstr("Held-out errors fall: positions from 0.0354 to 0.00354 rad."));
  EXPECT_THAT(join(make_leg()), HasSubstr("90 % of what a free model of the recorded signals predicts"));
}

// The sum over all signals hides what became better: the report of a walk names single equations.
TEST(Headline, ErrorsOfARobotOnItsFeetAreToldByEquation) {
  json report = make_leg();
  const auto fit = [](double before, double after, const char* unit) {
    return json{{"rms_before", before}, {"rms_after", after}, {"unit", unit}};
  };
  report["fit"]["per_signal"] = {
      {"/wrench/left/force (weight)", fit(10.5, 5.6, "N")},
      {"/joint_states/knee/effort (joint)", fit(9.5, 3.2, "N m")},
      {"/imu/waist/linear_acceleration (gravity)", fit(0.02, 0.019, "m/s^2")}};  // hardly falls
  EXPECT_THAT(join(report),
              HasSubstr("Held-out errors fall: effort of knee from 9.5 to 3.2 N m, weight from 10.5 to 5.6 N."));
}

// What a check of a walk found is one sentence of its own, with what else it can be.
TEST(Headline, ASingleFindingOfAWalkKeepsTheStatementOfItsCheck) {
  json report = make_leg();
  json load = make_finding("payload", "waist", "ambiguous", "mass", 1.08, 0.14, "kg");
  load["weight"] = 1.0;
  load["statement"] =
      "The feet carry 1.033 +- 0.004 of the weight. The model is too light by 3.3 %, or the scale is off. By phase.";
  report["findings"].push_back(load);
  const std::string text = join(report);
  EXPECT_THAT(
      text,
      HasSubstr("The feet carry 1.033 ± 0.004 of the weight. The model is too light by 3.3 %, or the scale is off."));
  EXPECT_THAT(text, Not(HasSubstr("By phase")));
  EXPECT_THAT(text, Not(HasSubstr("payload")));
}

TEST(Headline, APlaceThatIsAssumedHasNoInterval) {
  json load = make_finding("payload", "waist", "ambiguous", "mass", 1.08, 0.14, "kg");
  load["parameters"]["com"] = {{"value", {0.02, 0.0, -0.04}},
                               {"ci95", {{-1.94, 1.98}, {-1.96, 1.96}, {-2.0, 1.92}}},
                               {"unit", "m"},
                               {"assumed", true}};
  EXPECT_THAT(html::describe_parameters(load), HasSubstr("com (0.02, 0, -0.04) m (assumed)"));
}

TEST(Headline, OfEqualWeightTheMoreProbableStandsFirst) {
  json report = make_leg();
  json bias = make_finding("sensor_bias", "knee", "ambiguous", "value", 0.07, 0.03, "m/s^2"),
       load = make_finding("payload", "waist", "ambiguous", "mass", 1.0, 0.1, "kg");
  bias["weight"] = load["weight"] = 1.0;
  bias["probability"] = 0.5;
  load["probability"] = 0.95;
  report["findings"].push_back(bias);
  report["findings"].push_back(load);
  EXPECT_LT(join(report).find("payload at joint waist"), join(report).find("sensor bias at joint knee"));
}

TEST(Headline, OfLittleThatCanBePredictedTheShareOfAllIsTold) {
  json report = make_leg();
  report["ceiling"] = 0.02;
  report["explained"] = 0.018;
  EXPECT_THAT(join(report),
              HasSubstr("2 % of the mismatch, and 90 % of what a free model of the recorded signals predicts"));
}

TEST(Headline, WithoutAMeasureOfWhatCanBePredictedTheShareOfAllStandsAlone) {
  json report = make_leg();
  report["ceiling"] = 1.0;
  report["explained"] = 0.14;
  EXPECT_THAT(join(report), HasSubstr("Over all signals, that is 14 % of the mismatch."));
  report["ceiling"] = 0.14;  // the findings are what is predicted best
  EXPECT_THAT(
      join(report),
      HasSubstr(
          "Over all signals, that is 14 % of the mismatch; a free model of the recorded signals predicts no more."));
}

TEST(Headline, AFewFindingsKeepTheirOwnSentences) {
  json report = make_leg();
  report["findings"].erase(report["findings"].begin() + 2, report["findings"].end());
  EXPECT_THAT(join(report), HasSubstr("hip lacks it. thigh lacks it."));
}

TEST(Headline, AFindingToldAloneSaysWhatItCannotBeToldFromInTypesetUnits) {
  json report = make_leg();
  report["findings"].erase(report["findings"].begin() + 1, report["findings"].end());
  report["findings"][0]["statement"] = "hip: rotor, inertia 0.2 +- 0.1 kg m^2.";
  report["findings"][0]["alternatives"] = {{{"effect", "payload"}, {"where", {{"link", "shank"}}}}};
  EXPECT_THAT(
      join(report),
      HasSubstr("hip: rotor, inertia 0.2 ± 0.1 kg m². These recordings cannot tell it from: payload (link shank)."));
}

TEST(Headline, AMostlyUnexplainedPlaceIsNamedLast) {
  json report = make_leg();
  report["remaining"].push_back({{"share", 0.7}, {"statement", "knee: 0.5 of 0.6 N m remain."}});
  EXPECT_THAT(join(report), testing::EndsWith("Most is left here: knee: 0.5 of 0.6 N m remain."));
}

TEST(Headline, WhatTheModelHasBeyondTheFindingsIsSaidWithoutValues) {
  json report = make_leg();
  report["model"] = {
      {{"effect", "rotor_inertia"}, {"where", {{"joint", "ankle"}}}, {"grade", "not named: it helps to predict"}},
      {{"effect", "coulomb_friction"}, {"where", {{"joint", "hip"}}}, {"grade", "supported"}}};
  EXPECT_THAT(join(report), HasSubstr("The updated model also has, without proof: rotor inertia (ankle)."));
}

TEST(Headline, AStatementThatTheSummaryHasIsNotSaidAgain) {
  const json report = {{"verdict", "unexplained"},
                       {"summary", "Something is left out. knee: 2 N m."},
                       {"findings", json::array()},
                       {"unexplained", {{{"statement", "knee: 2 N m."}}, {{"statement", "hip: 3 N m."}}}}};
  EXPECT_EQ(join(report), "Something is left out. knee: 2 N m. hip: 3 N m.");
}

TEST(Headline, WithoutFindingsItSaysWhatTheEngineSaid) {
  const json report{{"verdict", "not_judged"},
                    {"findings", json::array()},
                    {"summary", "No efforts."},
                    {"unexplained", {{{"statement", "Add a column."}}}}};
  EXPECT_EQ(join(report), "No efforts. Add a column.");
}

TEST(Terminal, ADelayThatAllJointsShareIsOneRow) {
  const std::string text = make_terminal_text(make_leg());
  EXPECT_THAT(text, HasSubstr("4 joints     Command delay"));
  EXPECT_EQ(text.find("Command delay"), text.rfind("Command delay"));
}

TEST(Terminal, RowsStandInColumns) {
  const std::string text = make_terminal_text(make_leg());
  std::istringstream lines(text);
  std::string line;
  size_t column = 0;
  while (std::getline(lines, line)) {
    if (line.find("where") != std::string::npos && line.find("grade") != std::string::npos)
      column = line.find("effect");
    if (column > 0 && line.rfind("  joint hip", 0) == 0) {
      EXPECT_EQ(line.substr(column, 7), "Coulomb");
    }
  }
  EXPECT_GT(column, 0u);
}

// The leg with viscous friction in each joint, and a spring at one.
json make_whole_leg() {
  json report = make_leg();
  for (const char* joint : {"hip", "thigh", "knee", "ankle"})
    report["findings"].push_back(make_finding("viscous_friction", joint, joint[0] == 'k' ? "ambiguous" : "supported",
                                              "coefficient", 0.2, joint[0] * 1e-3, "N m s/rad"));
  json spring = make_finding("parallel_spring", "knee", "supported", "stiffness", 12.0, 2.0, "N m/rad");
  spring["parameters"]["rest"] = {{"value", 0.5}, {"unit", "rad"}};
  report["findings"].push_back(spring);
  for (const char* joint : {"knee", "ankle", "thigh", "hip"}) report["checks"]["joints"].push_back({{"joint", joint}});
  return report;
}

TEST(Terminal, ManyFindingsStandInARowAJointAndAColumnAnEffect) {
  const std::string text = make_terminal_text(make_whole_leg());
  const auto at = [&](const char* what) { return text.find(what); };
  EXPECT_THAT(text, HasSubstr("  joint  Coulomb friction [N m]  Viscous friction [N m s/rad]  other\n"));
  EXPECT_THAT(text, HasSubstr("  knee   1.1 \u00b1 0.05              (0.2 \u00b1 0.11)                  Parallel "
                              "spring: stiffness 12 \u00b1 2 N m/rad, rest 0.5 rad\n"));
  EXPECT_THAT(text, HasSubstr("  ankle  (0.1 \u00b1 0.05)            0.2 \u00b1 0.097\n"));
  EXPECT_LT(at("\n  ankle "), at("\n  thigh "));
  EXPECT_LT(at("\n  thigh "), at("\n  hip "));
  EXPECT_THAT(text, HasSubstr("4 joints  Command delay"));
  EXPECT_THAT(text, Not(HasSubstr("joint knee   Coulomb")));
}

TEST(Terminal, PartsOfTheWrongTypeAreLeftOut) {
  json report = make_leg();
  report["findings"][0] = 3;
  report["fit"] = "none";
  report["findings"][1]["where"] = {{"joint", 7}};
  EXPECT_THAT(make_terminal_text(report), Not(HasSubstr("Held-out")));
}

}  // namespace
}  // namespace hrp::diagnosis
