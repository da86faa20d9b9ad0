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

}  // namespace
}  // namespace hrp::diagnosis
