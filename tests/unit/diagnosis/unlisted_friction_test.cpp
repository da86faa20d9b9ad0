// SPDX-License-Identifier: BSD-3-Clause
// A gear that the load hardly turns competes with laws of friction that no effect describes.
#include <gtest/gtest.h>

#include <cmath>

#include "diagnosis/evidence/unlisted_friction.h"
#include "diagnosis/measurement/torque/terms.h"
#include "tests/unit/diagnosis/torque_verdicts.h"

namespace hrp::diagnosis {
namespace {

// Torque [N m] that the elbow's effort contains beside bodies and drive.
using Extra = double (*)(const JointColumns& shoulder, const JointColumns& elbow, size_t k);

double calc_direction(const JointColumns& joint, size_t k) { return std::tanh(joint.signal[1][k] / 0.02); }

Experiment make_arm(const std::string& name, const Hypothesis& hidden, Extra extra) {
  Experiment e = simulate_arm(name, hidden);
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) {
    std::vector<double> more(r.size());
    for (size_t k = 0; k < r.size(); ++k) more[k] = extra(r.joints[kShoulder], r.joints[kElbow], k);
    for (size_t k = 0; k < r.size(); ++k) r.joints[kElbow].signal[2][k] += more[k];
    forget_commands(&r);
  }
  return e;
}

// The unlisted law that does better than a gear at the elbow, beside viscous friction, dry friction and rotor.
std::string find_instead(const Experiment& e) {
  const TorqueData data = make_torque_data(e);
  FoundLaws laws{kElbow, {}, 50.0};
  std::vector<Eigen::VectorXd> gear;
  for (const TorqueRecording& r : data.recordings) {
    laws.columns.emplace_back(r.kept(), 0);
    for (const Term& term : list_joint_terms(data, kElbow)) {
      const Eigen::MatrixXd columns = calc_joint_columns(data, r, term);
      if (term.row->backwards) gear.push_back(columns);
      if (term.row->usual) {
        laws.columns.back().conservativeResize(Eigen::NoChange, laws.columns.back().cols() + 1);
        laws.columns.back().rightCols(1) = columns;
      }
    }
  }
  return find_unlisted_friction(data, laws, gear);
}

TEST(UnlistedFriction, FrictionThatFollowsThePostureIsToldFromAGear) {
  const Experiment e = make_arm("posture_friction", make_arm_drives(),
                                [](const JointColumns& shoulder, const JointColumns& elbow, size_t k) {
                                  return 0.8 * shoulder.signal[0][k] * calc_direction(elbow, k);
                                });
  EXPECT_EQ(find_instead(e), "dry friction that follows the position of shoulder");
}

TEST(UnlistedFriction, EffortsThatReadLessWithOneSignAreToldFromAGear) {
  const Experiment e =
      make_arm("one_sided_log", make_arm_drives(), [](const JointColumns&, const JointColumns& elbow, size_t k) {
        return elbow.signal[2][k] < 0.0 ? -0.2 * elbow.signal[2][k] : 0.0;
      });
  EXPECT_EQ(find_instead(e), "an effort that reads differently with each sign");
}

TEST(UnlistedFriction, AGearThatTheLoadHardlyTurnsIsNoneOfThem) {
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({find_effect("backdriving_friction")->id, kElbow, {0.6, 5e-4}});
  const auto nothing = [](const JointColumns&, const JointColumns&, size_t) { return 0.0; };
  EXPECT_EQ(find_instead(make_arm("gear_alone", hidden, nothing)), "");
}

}  // namespace
}  // namespace hrp::diagnosis
