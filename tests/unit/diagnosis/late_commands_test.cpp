// SPDX-License-Identifier: BSD-3-Clause
// Commands and positions without efforts: what the servos acted on is known from the log of the commands alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/conventions/late_commands.h"
#include "diagnosis/conventions/list_fit.h"
#include "diagnosis/conventions/log_conventions.h"
#include "diagnosis/data/command_reader.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

// Servos of an arm with friction and rotors: commands that were logged `late` [s], with or without their rates; no
// efforts.
Experiment make_logged(const std::string& name, double late, bool rates) {
  Experiment e = simulate_arm(name, make_arm_drives());
  for (Recording& r : e.recordings) {
    for (JointColumns& joint : r.joints) {
      const std::vector<double> command = joint.command, rate = joint.command_rate;
      for (size_t k = 0; k < r.size(); ++k) {
        joint.command[k] = interpolate(r.time, command, r.time[k] - late, k);
        joint.command_rate[k] = interpolate(r.time, rate, r.time[k] - late, k);
      }
      if (!rates) joint.command_rate.clear();
      joint.signal[static_cast<size_t>(Quantity::kEffort)].clear();
    }
  }
  return e;
}

constexpr double kLateVelocity = 0.02;  // [s]

// A drive with friction and a rotor of 0.05 kg m^2 swings a rod; kp 200, kd 10; no efforts. Its velocity is logged
// `logged_late` [s]. The servo damps with the velocity of `damping_late` [s] ago.
Experiment make_damped(const std::string& name, double damping_late, double logged_late = kLateVelocity) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("hrp_damped_" + name);
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "robot.urdf")
      << R"(<robot name="rod"><link name="base"/><link name="rod"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>
    <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.03"/></inertial></link><joint name="hinge" type="revolute"><parent link="base"/>
    <child link="rod"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="90" velocity="20"/></joint></robot>)";
  std::ofstream yaml(folder / "experiment.yaml");
  yaml << "robot: robot.urdf\nbase: fixed\nservo: {default: {kp: 200, kd: 10, effort_limit: 90}}\nrecordings:\n";
  for (int file = 0; file < 3; ++file) {
    yaml << "- {file: r" << file << ".csv, role: " << (file < 2 ? "train" : "validate") << "}\n";
    std::ofstream csv(folder / ("r" + std::to_string(file) + ".csv"));
    csv.precision(10);
    csv << "time,/joint_commands/hinge/position,/joint_states/hinge/position,/joint_states/hinge/velocity\n";
    const auto rate = [&](double t) { return 1.2 * std::cos((3.0 + file) * t) + 1.0 * std::cos(7.3 * t + file); };
    TestNoise noise;
    for (int k = 0; k < 1600; ++k) {
      const double t = 0.005 * k, v = rate(t), h = 1e-4, a = (rate(t + h) - rate(t - h)) / (2.0 * h);
      const double q = 1.2 / (3.0 + file) * std::sin((3.0 + file) * t) + 1.0 / 7.3 * std::sin(7.3 * t + file);
      const double rod =
          (0.03 + 2.0 * 0.2 * 0.2) * a - 2.0 * 9.81 * 0.2 * std::cos(q);  // gravity acts along -z, the rod along x
      const double drive = rod + 0.05 * a + 0.1 * v + 0.3 * std::tanh(v / 0.01);
      csv << t << "," << q + (drive + 10.0 * rate(t - damping_late)) / 200.0 << "," << q + 2e-5 * noise.draw() << ","
          << rate(t - logged_late) + 0.002 * noise.draw() << "\n";
    }
  }
  yaml.close();
  return load_experiment((folder / "experiment.yaml").string());
}

// kd T = 0.2 kg m^2 is more than the rotor has: with a sharp velocity, the rotor would be below zero.
TEST(LateCommands, AServoThatDampsWithItsLateVelocityHasARotorAboveZero) {
  const Experiment e = make_damped("late", kLateVelocity);
  const LateCommands late = find_late_commands(e, 1);
  ASSERT_TRUE(late.damps_late);
  EXPECT_FALSE(late.is_of_commands());
  EXPECT_TRUE(make_late_finding(e, late).is_null());
  const ListFit sharp = fit_list(e, 1), logged = fit_list(convert_commands(e, late), 1);
  EXPECT_LT(logged.cross[0] * logged.square[0], 0.1 * sharp.cross[0] * sharp.square[0]);
}

TEST(LateCommands, ALateLogOfTheVelocityAloneLeavesTheServoAsItIs) {
  EXPECT_FALSE(find_late_commands(make_damped("sharp", 0.0), 1).damps_late);
}

TEST(LateCommands, AFilterOfTheServosVelocityThatNoLogShowsIsFound) {
  const LateCommands late = find_late_commands(make_damped("filter", kLateVelocity, 0.0), 1);
  ASSERT_TRUE(late.damps_late);
  EXPECT_NEAR(late.filter, kLateVelocity, 0.01);  // the next ones that are tried
  EXPECT_FALSE(late.is_of_commands());
}

TEST(LateCommands, OfALogInTimeNothingIsSaid) {
  EXPECT_FALSE(find_late_commands(make_logged("commands_in_time", 0.0, true), 1).any());
}

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
  for (size_t j = 0; j < moved.cross.size(); ++j)
    EXPECT_LT(moved.cross[j], 0.1 * logged.cross[j]) << j;  // tenfold: nothing is left but friction's details
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
  for (const JointColumns& joint : converted.recordings[0].joints)
    EXPECT_EQ(joint.command_rate.size(), joint.command.size());
}

// A motor with a rotor and friction, kp 1, and a servo that damps the error of the velocity with kd; encoder counts.
// Neither efforts nor commanded velocities are logged.
Experiment make_position_loop(const std::string& name, double kd) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("hrp_loop_" + name);
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "robot.urdf") << R"(<robot name="motor"><link name="base"/><link name="rotor"><inertial>
    <mass value="0.1"/><inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0" izz="1e-5"/></inertial></link>
    <joint name="motor" type="continuous"><parent link="base"/><child link="rotor"/><axis xyz="0 0 1"/></joint></robot>)";
  std::ofstream yaml(folder / "experiment.yaml");
  yaml << "robot: robot.urdf\nbase: fixed\nservo: {default: {kp: 1, kd: " << kd
       << ", effort_limit: 0.5}}\nrecordings:\n";
  constexpr double kCount = 2.0 * M_PI / 4096;  // [rad]
  for (int file = 0; file < 2; ++file) {
    yaml << "- {file: r" << file << ".csv, role: " << (file < 1 ? "train" : "validate") << "}\n";
    std::ofstream csv(folder / ("r" + std::to_string(file) + ".csv"));
    csv.precision(10);
    csv << "time,/joint_commands/motor/position,/joint_states/motor/position\n";
    const double way = file < 1 ? 6.3 : -6.3, time = 0.75;  // [rad], [s] of one move with minimum jerk
    for (int k = 0; k < 120; ++k) {
      const double s = std::clamp(0.008 * k / time - 0.15, 0.0, 1.0);
      const double q = way * s * s * s * (10.0 + s * (6.0 * s - 15.0));
      const double v = way / time * 30.0 * s * s * (1.0 - s) * (1.0 - s);
      const double a = way / time / time * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s);
      const double texture = 4e-3 * std::sin((1.5 + 0.2 * q) * q);  // of no effect on the list
      const double torque = 1.1e-4 * a + 4e-4 * v + 4e-3 * std::tanh(v / 0.05) + texture;
      csv << 0.008 * k << "," << kCount * std::round((q + torque) / kCount) << "," << kCount * std::round(q / kCount)
          << "\n";
    }
  }
  yaml.close();
  return load_experiment((folder / "experiment.yaml").string());
}

// A delay of any size makes torques in proportion to speed, which friction then takes back: that is no evidence of it.
TEST(LateCommands, ADelayThatFrictionTakesBackIsNotBelieved) {
  for (double kd : {0.001, 0.005}) {
    const LateCommands late = find_late_commands(make_position_loop("taken_back", kd), 1);
    EXPECT_EQ(late.delay > 0.0 && !late.of_rate, false) << kd << ": " << late.delay;
  }
}

// The torque by a damping that does not act is many times what moves the joint: in proportion to such efforts, no
// motion shows that its law is another.
TEST(LateCommands, DampingThatIsMuchTooLargeIsSeenToActOnTheErrorOfTheVelocity) {
  EXPECT_TRUE(find_late_commands(make_position_loop("too_large", 0.01), 1).of_rate);
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
