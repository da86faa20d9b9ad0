// SPDX-License-Identifier: BSD-3-Clause
// What friction may be is not claimed.
#include "diagnosis/findings/doubtful_efforts.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/test_places.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

Experiment load_standing() { return load_experiment(source_dir() + "/models/experiments/standing/experiment.yaml"); }

Json make_supported(const char* effect, const char* family, const Json& where, const char* name, double value) {
  return {{"effect", effect},
          {"family", family},
          {"where", where},
          {"parameters", {{name, {{"value", value}}}}},
          {"grade", "supported"},
          {"statement", "A sentence."},
          {"alternatives", Json::array()}};
}

void rest(const char* joint, Experiment* e) {
  for (Recording& r : e->recordings) {
    std::vector<double>& q = r.joints[static_cast<size_t>(e->robot.tree.find_joint(joint))].signal[0];
    for (size_t k = 0; k < q.size(); ++k) q[k] = 0.3 + 0.001 * static_cast<double>(k % 2);
  }
}

Json judge_bias(const Experiment& e, const char* joint) {
  const std::string signal = std::string("/joint_states/") + joint + "/effort";
  Json report{{"findings", {make_supported("sensor_bias", "zero", {{"sensor", signal}}, "value", 0.9)}}};
  doubt_efforts_at_rest(e, &report);
  return report["findings"][0];
}

TEST(DoubtfulEfforts, AZeroOfAJointThatRestsMayBeItsFriction) {
  Experiment e = load_standing();
  rest("left_knee", &e);
  const Json finding = judge_bias(e, "left_knee");
  EXPECT_EQ(finding["grade"], "ambiguous");
  ASSERT_EQ(finding["alternatives"].size(), 1u);
  EXPECT_EQ(finding["alternatives"][0]["effect"], "coulomb_friction");
}

TEST(DoubtfulEfforts, AZeroOfAJointThatMovesStays) {
  EXPECT_EQ(judge_bias(load_standing(), "left_knee")["grade"], "supported");
}

// All efforts are `scale` times too large; the joints' equations keep this share of what they missed (root mean
// square).
Json judge_scale(double scale, double left, bool losses = false, bool servo = false) {
  const Experiment e = load_standing();
  Json report{{"findings", {make_supported("sensor_scale", "gain", {{"sensor", "/joint_states"}}, "scale", scale)}}};
  for (int j = 0; j < e.num_joints(); ++j) {
    const std::string& joint = e.robot.tree.joint(j).name;
    report["fit"]["per_signal"][e.signal_name(j, Quantity::kEffort) + " (joint)"] = {{"rms_before", 4.0},
                                                                                     {"rms_after", 4.0 * left}};
    if (servo)
      report["fit"]["per_signal"][e.signal_name(j, Quantity::kEffort) + " (servo)"] = {{"rms_before", 4.0},
                                                                                       {"rms_after", 4.0 * left}};
    // Losses of most drives, not of all.
    if (losses && j % 4 != 0)
      report["findings"].push_back(
          make_supported("coulomb_friction", "dry friction", {{"joint", joint}}, "level", 2.0));
  }
  doubt_common_scale(e, &report);
  return report["findings"][0];
}

TEST(DoubtfulEfforts, OneScaleOfAllEffortsMayBeLossesOfAllDrives) {
  EXPECT_EQ(judge_scale(5.2, 0.4)["grade"], "ambiguous");
}

TEST(DoubtfulEfforts, OneScaleThatLeavesNothingStays) { EXPECT_EQ(judge_scale(1.2, 0.05)["grade"], "supported"); }

TEST(DoubtfulEfforts, OneScaleBesideTheLossesOfTheDrivesStays) {
  EXPECT_EQ(judge_scale(1.2, 0.4, true)["grade"], "supported");
}

// Two equations of a joint are one drive.
TEST(DoubtfulEfforts, OneScaleBesideTheLossesOfMostDrivesStaysWhereServosAreComparedToo) {
  EXPECT_EQ(judge_scale(1.2, 0.4, true, true)["grade"], "supported");
}

// Losses make efforts larger, never smaller.
TEST(DoubtfulEfforts, OneScaleBelowOneIsNoLoss) { EXPECT_EQ(judge_scale(0.8, 0.4)["grade"], "supported"); }

}  // namespace
}  // namespace hrp::diagnosis
