// SPDX-License-Identifier: BSD-3-Clause
// A servo that holds each command until the next sample of the log, against viscous friction.
#include <gtest/gtest.h>

#include <fstream>

#include "tests/unit/diagnosis/torque_verdicts.h"

namespace hrp::diagnosis {
namespace {

constexpr double kViscous = 1.0, kDry = 1.5, kRotor = 0.05;  // [N m s/rad, N m, kg m^2] hidden in the hinge

// Of its servo [N m/rad, N m s/rad].
struct Gains {
  double kp = 900.0, kd = 20.0;
};
constexpr double kPeriod = 0.004, kStep = 1e-4;  // [s] of commands and log; of the simulation

double calc_command(double t) { return 0.5 * std::sin(3.0 * t) + 0.2 * std::sin(7.0 * t); }

// Writes a log of the pendulum. The log reads position and effort just after each new command.
void write_log(const std::filesystem::path& file, double from, const Gains& gains, bool velocity) {
  constexpr double kInertia = 0.03 + 2.0 * 0.2 * 0.2 + kRotor, kMoment = 2.0 * 0.2 * 9.81;  // [kg m^2, N m]
  TestNoise noise;
  std::ofstream csv(file);
  csv.precision(10);
  csv << "time,/joint_commands/hinge/position,/joint_states/hinge/position,/joint_states/hinge/effort";
  csv << (velocity ? ",/joint_states/hinge/velocity\n" : "\n");
  double q = calc_command(from), v = 0.0;
  for (int k = 0; k < 2500; ++k) {
    const double t = from + kPeriod * k, command = calc_command(t);
    for (int i = 0; i < std::lround(kPeriod / kStep); ++i) {
      const double effort = gains.kp * (command - q) - gains.kd * v;
      if (i == 0) {
        csv << kPeriod * k << "," << command << "," << q << "," << effort + 0.05 * noise.draw();
        csv << (velocity ? "," + std::to_string(v) + "\n" : "\n");
      }
      const double friction = kViscous * v + kDry * std::tanh(v / 1e-3);
      v += kStep / kInertia * (effort + kMoment * std::cos(q) - friction);
      q += kStep * v;
    }
  }
}

TorqueVerdict judge_held(const std::string& name, const Gains& gains = {}, bool velocity = false) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("hrp_held_commands_" + name);
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "robot.urdf") << kPendulum;
  std::ofstream(folder / "experiment.yaml")
      << "robot: robot.urdf\nbase: fixed\nservo: {default: {kp: " << gains.kp << ", kd: " << gains.kd << "}}\n"
      << "recordings:\n- {file: train.csv, role: train}\n- {file: validate.csv, role: validate}\n";
  write_log(folder / "train.csv", 0.0, gains, velocity);
  write_log(folder / "validate.csv", 20.0, gains, velocity);
  return judge_torque(load_experiment((folder / "experiment.yaml").string()), 1);
}

// The torque falls by kp T v from command to command. Its mean is kp T v / 2 below what the log reads: 1.8 N m s/rad
// beside a true 1.
TEST(HeldCommands, MayPushByAPeriodsShareOfTheStiffness) {
  const TorqueVerdict verdict = judge_held("snapshot");
  const Finding* f = find(verdict, "viscous_friction", "hinge");
  ASSERT_NE(f, nullptr);
  const double value = f->parameters[0].value[0], half = 1.96 * f->parameters[0].std[0];
  EXPECT_NEAR(value, kViscous + 0.5 * kPeriod * Gains{}.kp, 0.3);  // what the log shows; 0.3 for the servo's own lag
  EXPECT_LT(value - half, kViscous);
  EXPECT_GT(value + half, kViscous);
}

// The velocity just after a command is kp T^2 / (12 I) below the mean rate: 7 % here, where I is 0.16 kg m^2.
TEST(HeldCommands, LetTheVelocityRippleByWhatLooksLikeAScale) {
  const TorqueVerdict verdict = judge_held("ripple", {9000.0, 60.0}, true);
  const Finding* f = find(verdict, "sensor_scale", "/joint_states/hinge/velocity");
  ASSERT_NE(f, nullptr);
  EXPECT_NEAR(f->parameters[0].value[0], 1.0 - 9000.0 * kPeriod * kPeriod / (12.0 * 0.16), 0.02);
  EXPECT_EQ(f->grade, Grade::kAmbiguous) << f->statement;
  EXPECT_NE(f->statement.find("holds its commands"), std::string::npos) << f->statement;
}

// Dry friction is a level: it has no part in proportion to the speed.
TEST(HeldCommands, DoNotDoubtDryFriction) {
  const TorqueVerdict verdict = judge_held("dry");
  const Finding* f = find(verdict, "coulomb_friction", "hinge");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->grade, Grade::kSupported) << f->statement;
  EXPECT_NEAR(f->parameters[0].value[0], kDry, 1.96 * f->parameters[0].std[0]);
}

}  // namespace
}  // namespace hrp::diagnosis
