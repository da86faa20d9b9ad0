// SPDX-License-Identifier: BSD-3-Clause
// What the feet carry against what the model weighs: by phase, and in short recordings.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "diagnosis/floating/checks/foot_scales.h"
#include "diagnosis/floating/diagnose.h"
#include "tests/unit/diagnosis/legged/biped.h"

namespace hrp::diagnosis::floating {
namespace {

// Shares of the weight on the left foot alone, the right one alone, and both.
std::map<int, Consensus> make_phases(double left, double right, double both) {
  return {{1, {left, 0.01, 8, 0}}, {2, {right, 0.01, 8, 0}}, {3, {both, 0.002, 8, 0}}};
}

TEST(FootScales, OfOneFootShowByWhatItBears) {
  const std::vector<FootScale> scales = list_foot_scales(make_phases(0.894, 1.010, 0.960), 2);
  ASSERT_FALSE(scales.empty());
  EXPECT_EQ(scales[0].foot, 0u);
  EXPECT_NEAR(scales[0].scale, 0.9, 0.01);  // the shares scatter by 1 %
  EXPECT_LT(scales[0].left, 0.25);
}

TEST(FootScales, DoNotTakeThePlaceOfAMass) {
  for (const FootScale& s : list_foot_scales(make_phases(1.030, 1.032, 1.031), 2)) EXPECT_GT(s.left, 0.25);
  for (const FootScale& s : list_foot_scales(make_phases(0.985, 1.011, 1.033), 2)) EXPECT_GT(s.left, 0.25);
  EXPECT_TRUE(list_foot_scales({{3, {0.95, 0.002, 8, 0}}}, 2).empty()) << "a robot that stands on both feet";
}

// Vertical forces of 2.2 s, in one recording.
Experiment make_short(double heavier) {
  Recorded recorded = kLeans;
  recorded.six_axes = false;
  Hidden hidden;
  hidden.heavier = heavier;
  Experiment e = make_biped(hidden, recorded);
  e.recordings.resize(1);
  Recording& r = e.recordings[0];
  r.time.resize(550);
  for (JointColumns& joint : r.joints) joint.signal[0].resize(550);
  for (auto& [name, column] : r.other) column.resize(550);
  return e;
}

// As in the legs and arms of the iCub. Forces that the feet's own sensors tell count once.
TEST(Sensors, WithinALimbAreNoForcesOfTheGround) {
  Experiment e = make_short(1.2);
  const std::vector<Finding> before = diagnose_legged(e, nullptr).evidence.findings;
  std::string scenario = kBipedScenario;
  scenario.replace(scenario.find("wrench: {"), 9, "wrench: {thigh: {link: l_thigh}, ");
  e.scenario = parse_scenario(scenario, "biped.yaml");
  for (Recording& r : e.recordings) r.other["/wrench/thigh/force/z"] = r.other.at("/wrench/l/force/z");
  const Evidence with = diagnose_legged(e, nullptr).evidence;
  ASSERT_EQ(with.findings.size(), before.size());
  EXPECT_EQ(with.findings[0].statement, before[0].statement);
  EXPECT_TRUE(std::any_of(with.missing.begin(), with.missing.end(), [](const std::string& text) {
    return text.find("force sensor thigh") != std::string::npos;
  }));
}

TEST(ShortRecordings, OfSensorsThatHangUpsideDownSayTheSameWeight) {
  Experiment turned = make_short(1.2);
  hang_upside_down(&turned);
  const std::vector<Finding> as_usual = diagnose_legged(make_short(1.2), nullptr).evidence.findings,
                             findings = diagnose_legged(turned, nullptr).evidence.findings;
  ASSERT_EQ(as_usual.size(), 1u);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].effect, as_usual[0].effect) << findings[0].statement;
  EXPECT_NEAR(findings[0].parameters[0].value[0], as_usual[0].parameters[0].value[0], 1e-6) << "the same readings";
}

TEST(ShortRecordings, SayAWeightThatIsPlainlyOffAndWhatItMayBe) {
  const std::vector<Finding> findings = diagnose_legged(make_short(1.2), nullptr).evidence.findings;
  ASSERT_EQ(findings.size(), 1u);
  const Finding& f = findings[0];
  EXPECT_EQ(f.where.at("link"), "pelvis") << "nothing tells which link it is: " << f.statement;
  EXPECT_EQ(f.grade, Grade::kAmbiguous);
  EXPECT_TRUE(std::any_of(f.alternatives.begin(), f.alternatives.end(), [](const Alternative& a) {
    return a.effect == "sensor_scale" && a.where.at("sensor") == "/wrench";
  }));
  ASSERT_EQ(f.effect, "payload");
  EXPECT_TRUE(f.parameters[1].assumed) << "vertical forces alone do not tell where a load is";
  EXPECT_TRUE(diagnose_legged(make_short(1), nullptr).evidence.findings.empty());
}

}  // namespace
}  // namespace hrp::diagnosis::floating
