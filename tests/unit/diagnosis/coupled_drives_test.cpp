// SPDX-License-Identifier: BSD-3-Clause
// Friction of a motor that turns with two joints is told from friction of the joints.
#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "diagnosis/evidence/coupled_drives.h"
#include "tests/unit/diagnosis/torque_verdicts.h"

namespace hrp::diagnosis {
namespace {

constexpr double kRatio = 0.7, kLevel = 1.5;  // [1], [N m]: as much as the shoulder's own friction

// The arm's efforts contain friction of a motor that turns at the shoulder's rate plus `ratio` times the elbow's.
Experiment make_coupled(const std::string& name, double level, const Hypothesis& hidden) {
  Experiment e = simulate_arm(name, hidden);
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) {
    for (size_t k = 0; k < r.size(); ++k) {
      const double rate = r.joints[kShoulder].signal[1][k] + kRatio * r.joints[kElbow].signal[1][k];
      const double torque = level * std::tanh(rate / 0.01) + 0.3 * level * rate;
      r.joints[kShoulder].signal[2][k] += torque;
      r.joints[kElbow].signal[2][k] += kRatio * torque;
    }
    forget_commands(&r);
  }
  return e;
}

const Remaining& get_remaining(const TorqueVerdict& verdict, int joint) {
  for (const Remaining& r : verdict.evidence.remaining) {
    if (r.where.begin().value() == kArmJoints[static_cast<size_t>(joint)]) return r;
  }
  throw std::logic_error("not judged");
}

void expect_uncoupled(const TorqueVerdict& verdict) {
  for (const Remaining& r : verdict.evidence.remaining)
    EXPECT_EQ(r.statement.find("two joints"), std::string::npos) << r.statement;
  for (const Remaining& r : verdict.evidence.remaining)
    EXPECT_EQ(r.statement.find("both joints"), std::string::npos) << r.statement;
}

// The laws of single joints took it before: supported viscous friction, several times too large.
TEST(CoupledDrives, FrictionAtTheRateOfTwoJointsIsSaidAndNoLawOfOneJointIsSupported) {
  const TorqueVerdict verdict = judge_torque(make_coupled("coupled", kLevel, make_arm_drives()), 1);
  for (int joint : {kShoulder, kElbow}) {
    const Remaining& r = get_remaining(verdict, joint);
    EXPECT_EQ(r.depends_on, std::vector<std::string>{"other joint"}) << r.statement;
  }
  for (const Finding& f : verdict.evidence.findings) EXPECT_NE(f.grade, Grade::kSupported) << f.statement;
}

// Both motors of a parallelogram stand on the base: the second one turns at the sum of both rates and takes the
// forearm's weight off the first. A force that lifts the forearm was supported before.
TEST(CoupledDrives, WhatMotorsOfAParallelogramCarryIsNotTold) {
  Experiment e = simulate_arm("coupled_parallelogram", {});
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) {
    JointColumns &shoulder = r.joints[kShoulder], &elbow = r.joints[kElbow];
    for (size_t k = 0; k < r.size(); ++k) {
      const double v = shoulder.signal[1][k], sum = v + elbow.signal[1][k];
      shoulder.signal[2][k] += 0.8 * std::tanh(v / 0.01) + 0.3 * v - elbow.signal[2][k];
      elbow.signal[2][k] += 0.4 * std::tanh(sum / 0.01) + 0.2 * sum;
    }
    forget_commands(&r);
  }
  for (const Finding& f : judge_torque(e, 1).evidence.findings)
    EXPECT_FALSE(f.where.contains("link") && f.grade == Grade::kSupported) << f.statement;
}

TEST(CoupledDrives, RatioAndLevelAreThoseOfTheMotor) {
  const Experiment e = make_coupled("coupled_values", kLevel, {});
  const CoupledDrives found = find_coupled_drives(make_torque_data(e), {kShoulder, {}, 50.0});
  ASSERT_EQ(found.drives.size(), 1u);
  EXPECT_EQ(found.drives[0].other, kElbow);
  EXPECT_NEAR(found.drives[0].ratio, kRatio, 0.05 * kRatio);  // the sign differs at few samples within 5 %
  EXPECT_NEAR(found.drives[0].level, kLevel, 0.05 * kLevel);  // filtered signs of noisy rates
}

TEST(CoupledDrives, DrivesWithFrictionOfTheirOwnAreNotCoupled) {
  const TorqueVerdict verdict = judge_torque(make_coupled("uncoupled", 0.0, make_arm_drives()), 1);
  expect_uncoupled(verdict);
  expect_drives(verdict, make_arm_drives());
}

// A load moves with both joints, and a late log differs most where they turn around.
TEST(CoupledDrives, AWrongMassOrALateLogIsNoCoupling) {
  Experiment e = make_coupled("uncoupled_load", 0.0, make_arm_drives());
  e.robot.tree.links[kFore].inertia.mass *= 0.5;
  expect_uncoupled(judge_torque(e, 1));
  for (Recording& r : e.recordings) {
    std::vector<double>& effort = r.joints[kElbow].signal[2];
    std::rotate(effort.rbegin(), effort.rbegin() + 4, effort.rend());
  }
  expect_uncoupled(judge_torque(e, 1));
}

TEST(CoupledDrives, ATextureOfFrictionIsNoCoupling) {
  Experiment e = make_coupled("uncoupled_texture", 0.0, make_arm_drives());
  add_texture(0.8, &e);
  expect_uncoupled(judge_torque(e, 1));
}

}  // namespace
}  // namespace hrp::diagnosis
