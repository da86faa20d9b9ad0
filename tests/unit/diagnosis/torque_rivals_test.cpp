// SPDX-License-Identifier: BSD-3-Clause
// Which laws a report lists as ones that the recordings cannot tell apart.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/evidence/torque_findings.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

// Adds dry friction to the efforts of the shoulder: a share of the load in the training recordings, in the others that or a
// constant level of the same mean size.
Experiment make_friction(const std::string& name, bool constant_in_held_out) {
  Experiment e = make_simulated_experiment(name, kArm, {"shoulder", "elbow"}, {});
  constexpr double kRatio = 0.3;
  for (Recording& r : e.recordings) {
    JointColumns& joint = r.joints[0];
    double mean = 0.0;
    for (double effort : joint.signal[2]) mean += std::abs(effort) / static_cast<double>(r.size());
    const bool constant = constant_in_held_out && !r.spec.train;
    for (size_t k = 0; k < r.size(); ++k)
      joint.signal[2][k] += kRatio * (constant ? mean : std::abs(joint.signal[2][k])) * std::tanh(joint.signal[1][k] / 0.02);
  }
  return e;
}

// The finding of dry friction at the shoulder, and whether it lists a constant level.
bool lists_constant_level(const Experiment& e) {
  for (const Finding& f : judge_torque(e, 1).evidence.findings) {
    if (f.effect != get_effect(EffectId::kLoadFriction).name || f.where.begin().value() != "shoulder") continue;
    EXPECT_EQ(f.grade, Grade::kSupported) << f.statement;
    const std::string constant = get_effect(EffectId::kCoulomb).name;
    return std::any_of(f.alternatives.begin(), f.alternatives.end(), [&](const auto& a) { return a.effect == constant; });
  }
  ADD_FAILURE() << "no friction of the load";
  return false;
}

// Odds in the training recordings alone decided before. A real arm was told friction of the load without a word of the
// constant level that predicts its held-out recording better.
TEST(TorqueRivals, DryFrictionThatPredictsHeldOutRecordingsBetterIsListed) {
  EXPECT_TRUE(lists_constant_level(make_friction("rivals_constant", true)));
  EXPECT_FALSE(lists_constant_level(make_friction("rivals_load", false)));
}

// Drives that give three quarters of what they log, behind friction that takes most of the effort: what is missing of the
// weight looks like a force that lifts a link, or like a light link.
TEST(TorqueRivals, GainsOfTheDrivesAreListedBesideAForceThatCarriesTheirWeight) {
  Hypothesis hidden{{EffectId::kViscous, kShoulder, {12.0}}, {EffectId::kCoulomb, kShoulder, {8.0, 0.0, 5e-4}},
                    {EffectId::kViscous, kElbow, {6.0}}, {EffectId::kCoulomb, kElbow, {4.0, 0.0, 5e-4}}};
  Experiment e = simulate_arm("rivals_gains", hidden);
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) {
    for (JointColumns& joint : r.joints) {
      for (double& y : joint.signal[2]) y *= 0.75;
    }
  }
  const std::string gain = get_effect(EffectId::kTorqueConstant).name;
  bool any = false;
  for (const Finding& f : judge_torque(e, 1).evidence.findings) {
    any = any || f.effect == gain;
    if (!f.where.contains("link")) continue;
    EXPECT_NE(f.grade, Grade::kSupported) << f.statement;
    any = any || std::any_of(f.alternatives.begin(), f.alternatives.end(), [&](const auto& a) { return a.effect == gain; });
  }
  EXPECT_TRUE(any);
}

}  // namespace
}  // namespace hrp::diagnosis
