// SPDX-License-Identifier: BSD-3-Clause
// Ranges of a Stribeck curve, where recordings differ.
#include <gtest/gtest.h>

#include "diagnosis/evidence/torque_design.h"
#include "diagnosis/evidence/torque_stribeck.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

// Four training recordings of an elbow with this Stribeck velocity in each [rad/s].
Experiment make_elbow(const std::string& name, const std::vector<double>& velocities) {
  Experiment all;
  for (size_t i = 0; i < velocities.size(); ++i) {
    Hypothesis hidden = make_arm_drives();
    hidden[4] = {EffectId::kStribeck, kElbow, {0.8, 1.6, velocities[i], 0.0, 5e-4}};
    Experiment one = simulate_arm(name + std::to_string(i), hidden);
    if (i == 0) all = one, all.recordings.clear();
    all.recordings.push_back(one.recordings[i % 2]);
    all.recordings.back().spec.train = true;
  }
  return all;
}

Range find_velocity(const Experiment& e) {
  const TorqueDesign design = make_torque_design(make_torque_data(e));
  const DryCurve curve = profile_dry_curve(design, choose_torque_model(design, 1).model, kElbow);
  EXPECT_TRUE(curve.there);
  return curve.velocity;
}

TEST(StribeckRanges, HoldWhatRecordingsDifferBy) {
  const Range alike = find_velocity(make_elbow("curve_alike", {0.2, 0.2, 0.2, 0.2})), differ = find_velocity(make_elbow("curve_differs", {0.1, 0.1, 0.4, 0.4}));
  EXPECT_LT(alike.high, 2.0 * alike.low);
  EXPECT_LT(differ.low, 0.15);  // three quarters of the way to the slow ones
  EXPECT_GT(differ.high, 0.3);
}

}  // namespace
}  // namespace hrp::diagnosis
