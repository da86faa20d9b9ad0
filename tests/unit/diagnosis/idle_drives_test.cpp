// SPDX-License-Identifier: BSD-3-Clause
// A robot that somebody moves by hand: its drives are off, and the log of efforts is noise.
#include <gtest/gtest.h>

#include "diagnosis/evidence/idle_drives.h"
#include "tests/unit/diagnosis/torque_verdicts.h"

namespace hrp::diagnosis {
namespace {

Experiment move_by_hand(const std::string& name) {
  Experiment e = simulate_arm(name, make_arm_drives());
  e.scenario.drive = "effort";
  TestNoise noise;
  for (Recording& r : e.recordings) {
    forget_commands(&r);
    for (JointColumns& joint : r.joints) {
      for (double& effort : joint.signal[2]) effort = 0.02 * noise.draw();  // [N m]; its weight takes 9 N m
    }
  }
  return e;
}

TEST(IdleDrives, NothingIsSupportedOfARobotThatIsMovedByHandAndTheReportSaysWhy) {
  const TorqueVerdict verdict = judge_torque(move_by_hand("moved_by_hand"), 1);
  for (const Finding& f : verdict.evidence.findings) EXPECT_NE(f.grade, Grade::kSupported) << f.statement;
  const auto& warnings = verdict.evidence.warnings;
  EXPECT_TRUE(std::any_of(warnings.begin(), warnings.end(),
                          [](const std::string& w) { return w.find("by hand") != std::string::npos; }));
}

TEST(IdleDrives, DrivesThatMoveTheRobotAreNotIdle) {
  EXPECT_FALSE(are_drives_idle(make_torque_data(simulate_arm("moved_by_drives", make_arm_drives()))));
}

// Its effort is 0 by its kind, and no log that follows nothing.
TEST(IdleDrives, AJointWithoutADriveBesideServosSaysNothingOfThem) {
  Experiment e = simulate_arm("servos_and_a_hinge", make_arm_drives());
  TorqueData data = make_torque_data(e);
  e.robot.tree.joint(kElbow).actuated = false;
  data.source = {EffortSource::kServoLaw, EffortSource::kRecorded};
  for (TorqueRecording& r : data.recordings) r.effort.col(kElbow).setZero();
  EXPECT_FALSE(are_drives_idle(data));
}

}  // namespace
}  // namespace hrp::diagnosis
