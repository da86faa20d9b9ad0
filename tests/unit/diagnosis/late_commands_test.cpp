// SPDX-License-Identifier: BSD-3-Clause
// Commands and positions without efforts: what the servos acted on is known from the log of the commands alone.
#include <gtest/gtest.h>

#include "diagnosis/conventions/late_commands.h"
#include "diagnosis/conventions/list_fit.h"
#include "diagnosis/conventions/log_conventions.h"
#include "diagnosis/data/command_reader.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

// Servos of an arm with friction and rotors: commands that were logged `late` [s], with or without their rates; no efforts.
Experiment make_logged(const std::string& name, double late, bool rates) {
  Experiment e = simulate_arm(name, make_arm_drives());
  for (Recording& r : e.recordings) {
    for (JointColumns& joint : r.joints) {
      const std::vector<double> command = joint.command, rate = joint.command_rate;
      for (size_t k = 0; k < r.size(); ++k) {
        joint.command[k] = interpolate(r.time, command, r.time[k] - late, k), joint.command_rate[k] = interpolate(r.time, rate, r.time[k] - late, k);
      }
      if (!rates) joint.command_rate.clear();
      joint.signal[static_cast<size_t>(Quantity::kEffort)].clear();
    }
  }
  return e;
}

TEST(LateCommands, OfALogInTimeNothingIsSaid) { EXPECT_FALSE(find_late_commands(make_logged("commands_in_time", 0.0, true), 1).any()); }

// Without the delay, no friction explains anything: it would have to drive the joints.
TEST(LateCommands, ALogThatIsLateIsToldFromRotorsAndFriction) {
  const Experiment e = make_logged("commands_late", 0.02, true);
  const LateCommands late = find_late_commands(e, 1);
  ASSERT_TRUE(late.any());
  EXPECT_FALSE(late.of_rate);
  EXPECT_NEAR(late.delay, 0.02, 0.003);  // half a step of the delays that are tried
  EXPECT_NEAR(late.delay, 0.02, 3.0 * late.std);
  EXPECT_EQ(make_late_finding(e, late)["grade"], "supported");
  const ListFit logged = fit_list(e, 1), moved = fit_list(convert_commands(e, late), 1);
  for (size_t j = 0; j < moved.cross.size(); ++j) EXPECT_LT(moved.cross[j], 0.1 * logged.cross[j]) << j;  // tenfold: nothing is left but friction's details
}

// kd (r' - q') with r' not logged: the joints seem to be driven by their friction.
TEST(LateCommands, ServosThatDampTheErrorOfTheVelocityGetItsCommandFromThePositions) {
  const Experiment e = make_logged("commands_rate", 0.0, false);
  const LateCommands late = find_late_commands(e, 1);
  ASSERT_TRUE(late.of_rate);
  EXPECT_NE(describe(late).find("no commanded velocity was logged"), std::string::npos);
  // To first order, the same as a log that is late by kd / kp = 50 ms: never a sure finding.
  const Json finding = make_late_finding(e, late);
  EXPECT_TRUE(finding.is_null() || finding["grade"] == "ambiguous");
  const Experiment converted = convert_commands(e, late);
  for (const JointColumns& joint : converted.recordings[0].joints) EXPECT_EQ(joint.command_rate.size(), joint.command.size());
}

// Recorded efforts do not depend on the log of the commands.
TEST(LateCommands, WithEffortsNoCommandIsMoved) {
  Experiment e = simulate_arm("commands_efforts", make_arm_drives());
  for (Recording& r : e.recordings) {
    for (JointColumns& joint : r.joints) joint.command_rate.clear();
  }
  EXPECT_FALSE(find_late_commands(e, 1).any());
}

}  // namespace
}  // namespace hrp::diagnosis
