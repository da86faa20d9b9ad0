// SPDX-License-Identifier: BSD-3-Clause
// Every number of a scenario, replaced by values that nobody means: refused with file and line, or simulated with a
// status. Never a crash, a hang or a state that is not finite.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/physics/scenario_robot.h"

namespace hrp {
namespace {

// All sections with numbers; '#' lines are none. Motion, logging and walk have tests of their own.
const char kEverything[] = R"(robot: ../hrp2p_like/hrp2p_like.urdf
gravity: [0, 0, -9.81]
ground: {height: 0, friction: 0.8, roll: 0.01, pitch: 0.01}
feet: [L_ANKLE_R_LINK, R_ANKLE_R_LINK]
max_sole_points: 4
contact: {stiffness: 1e6, exponent: 1.5, alpha: 2.4, tangential_damping: 2e3, tangential_stiffness: 1e6, restitution: 0.1, shared_points: 4, length_scale: 0.1}
foot_bush: {default: {kz: 3e5, cz: 800, k_roll: 900, c_roll: 15, k_pitch: 900, c_pitch: 15, offset_roll: 0.1, offset_pitch: 0.1, upper_mass_ratio: 0.2, hardening_angle: 0.05, center: [0, 0, -0.1]}}
obstacles: {box: {size: [0.1, 0.1, 0.1], position: [2, 0, 0], rpy: [0, 0, 0.1], friction: 0.5}, ball: {shape: sphere, radius: 0.2, position: [3, 0, 0]}, drum: {shape: cylinder, radius: 0.2, length: 0.3, position: [4, 0, 0]}}
servo: {default: {kp: 3000, kd: 30, effort_limit: 300}, joints: {R_KNEE: {kp: 5000, kd: 50}}}
initial: {rpy: [0, 0, 0.1], joints: {R_ELBOW: -0.5}}
rotor_inertia: {R_KNEE: 0.3}
joint_laws: {R_KNEE: {coulomb_friction: {level: 2, asymmetry: 0.1}, command_delay: {delay: 0.003}}, L_KNEE: {backlash: {gap: 0.001}, cogging: {amplitude: 1, periods: 20, phase: 0.1}}, L_ELBOW: {joint_elasticity: {stiffness: 900, damping: 2, rotor_inertia: 0.1}, hysteresis: {stiffness: 10, yield_angle: 0.01}}, R_ELBOW: {stribeck_friction: {coulomb: 1, static: 2, stribeck_velocity: 0.1, viscous: 0.2}, actuator_lag: {time_constant: 0.005}, torque_saturation: {limit: 50}}}
link_laws: {WAIST_P_LINK: {payload: {mass: 1, com: [0, 0, 0.1]}, mass_error: {scale: 1.1}, com_error: {offset: [0, 0, 0.01]}, external_force: {force: [1, 0, 0]}}}
sensors: {imu: {chest: {link: CHEST_IMU, xyz: [0, 0, 0.1], gyro: {noise: 0.01, bias: 0.1, delay: 0.002, quantum: 0.001, scale: 1.1, misalignment: [0, 0, 0.1], clock_skew: 0.001}}}, wrench: {left: {link: L_ANKLE_R_LINK, force: {noise: [1, 1, 1], delay: 0.002}}}, encoders: {position_noise: 1e-5, velocity_noise: 1e-4, effort_noise: 0.1, position_quantum: 1e-5}}
steps: {time_step: 0.001, control_period: 0.005, duration: 2}
variation: {mass: 0.05, pose: 0.01}
seed: 3
)";

// Where the numbers of the text stand: begin, length.
std::vector<std::pair<size_t, size_t>> find_numbers(const std::string& text) {
  std::vector<std::pair<size_t, size_t>> found;
  const std::string digits = "0123456789.e-+";
  for (size_t i = 1; i < text.size(); ++i) {
    const char before = text[i - 1];
    const bool starts = (std::isdigit(text[i]) != 0 || text[i] == '-') && (before == ' ' || before == '[');
    if (!starts) continue;
    const size_t end = text.find_first_not_of(digits, i);
    found.emplace_back(i, end - i);
    i = end;
  }
  return found;
}

// What came of it, for counting.
enum class Fate { kRefused, kSimulated, kStopped };

Fate try_scenario(const std::string& yaml) {
  try {
    ScenarioRobot run(yaml);
    for (int k = 0; k < 20; ++k) {
      const StepStatus status = run.step();
      EXPECT_TRUE(run.simulator.state().q.allFinite() && run.simulator.state().p_WB.allFinite());
      if (status == StepStatus::kOk) continue;
      EXPECT_FALSE(run.simulator.fault_text().empty());
      return Fate::kStopped;
    }
    return Fate::kSimulated;
  } catch (const InputError& error) {
    EXPECT_FALSE(error.diagnostics().empty());
    for (const Diagnostic& diagnostic : error.diagnostics()) {
      EXPECT_FALSE(diagnostic.field.empty()) << diagnostic.message;
      // Said by the loader, with a line; what only the simulator can know has none.
      if (!diagnostic.file.empty()) {
        EXPECT_GT(diagnostic.line, 0) << error.what();
      }
    }
    return Fate::kRefused;
  }
}

TEST(HostileScenario, TheTextIsGoodToBeginWith) { EXPECT_EQ(try_scenario(kEverything), Fate::kSimulated); }

class HostileValue : public ::testing::TestWithParam<const char*> {};

TEST_P(HostileValue, InAnyKeyIsRefusedOrSimulatedWithAStatus) {
  const std::string text = kEverything;
  const std::string value = GetParam();
  const bool no_number = value == ".nan" || value == "1e300" || value == "-1e300";
  const auto numbers = find_numbers(text);
  ASSERT_GT(numbers.size(), 100u);
  for (const auto& [at, length] : numbers) {
    std::string changed = text;
    changed.replace(at, length, value);
    const size_t line = text.rfind('\n', at) + 1;
    SCOPED_TRACE(text.substr(std::max(line, at > 50 ? at - 50 : 0), 70));
    const Fate fate = try_scenario(changed);
    if (no_number) {
      EXPECT_EQ(fate, Fate::kRefused) << "no number for anything";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Values, HostileValue,
                         ::testing::Values("-1", "0", ".nan", ".inf", "-.inf", "1e300", "-1e300", "1e12", "-1e12",
                                           "1e-300", "0.5"),
                         [](const auto& info) { return "Value" + std::to_string(info.index); });

}  // namespace
}  // namespace hrp
