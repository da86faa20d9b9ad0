// SPDX-License-Identifier: BSD-3-Clause
// A servo whose stated damping gain is wrong, in logs of commands and positions.
#include <gmock/gmock.h>

#include "tests/unit/diagnosis/torque_verdicts.h"

namespace hrp::diagnosis {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// The servo has 10 N m s/rad.
TorqueVerdict judge_stated(const std::string& name, double kd) {
  Experiment e = make_simulated_experiment(name, kArm, kArmJoints, make_arm_drives());
  e.scenario.servo_default.kd = kd;
  for (Recording& r : e.recordings) {
    for (JointColumns& joint : r.joints) joint.signal[2].clear();
  }
  return judge_torque(e, 1);
}

const std::string& get_rest(const TorqueVerdict& verdict, const std::string& joint) {
  for (const Remaining& r : verdict.evidence.remaining) {
    if (r.where.at("joint") == joint) return r.statement;
  }
  static const std::string none;
  return none;
}

// Lags and constant torques were supported in its place.
TEST(ServoDamping, ThatIsStatedTwiceTooLargeIsSaidAndNothingStandsInForIt) {
  const TorqueVerdict verdict = judge_stated("damping_large", 20.0);
  for (const char* joint : {"shoulder", "elbow"}) {
    EXPECT_THAT(
        get_rest(verdict, joint),
        ::testing::ContainsRegex("With a damping gain kd of (9[.][5-9]|10) N m s/rad in place of the stated 20"));
    for (const char* effect : {"constant_torque", "actuator_lag", "command_delay", "parallel_spring"}) {
      const Finding* f = find(verdict, effect, joint);
      EXPECT_TRUE(!f || f->grade == Grade::kAmbiguous) << f->statement;
    }
  }
}

TEST(ServoDamping, ThatIsStatedRightIsNotMentioned) {
  const TorqueVerdict verdict = judge_stated("damping_right", 10.0);
  for (const char* joint : {"shoulder", "elbow"}) EXPECT_THAT(get_rest(verdict, joint), Not(HasSubstr("damping gain")));
}

}  // namespace
}  // namespace hrp::diagnosis
