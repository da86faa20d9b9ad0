// SPDX-License-Identifier: BSD-3-Clause
// A servo's step with friction, a late command and a bench that shakes: most is taken away by effects of the list, and
// much is left beside many steps of the encoder. What takes it away is told with its values.
#include <gmock/gmock.h>

#include "diagnosis/diagnose_recordings.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* kLever = R"(<robot name="lever"><link name="base"/>
  <link name="arm"><inertial><origin xyz="0.1 0 0"/><mass value="0.6"/>
    <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.004" iyz="0" izz="0.004"/></inertial></link>
  <joint name="servo" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="8" velocity="20"/></joint></robot>)";
constexpr double kDrag = 0.6, kLate = 0.08;         // [N m s/rad, s] hidden
constexpr double kShaken = 0.015, kShaking = 40.0;  // [rad, rad/s] of the bench, which no effect of the list has
constexpr double kEncoder = 0.0015;                 // [rad] a step of 12 bits
constexpr double kPeriod = 0.01;                    // [s]

// Commands that step from `from` to `to` after half a second; the positions' column is replaced by a simulated one
// later.
void write_step(const fs::path& path, double from, double to) {
  std::ofstream csv(path);
  csv << "time,/joint_commands/servo/position,/joint_states/servo/position\n";
  for (int k = 0; k < 150; ++k) {
    const double command = k < 50 ? from : to;
    csv << kPeriod * k << "," << command << "," << command << "\n";
  }
}

// A rise and a fall, the latter held out; positions in steps of the encoder.
Experiment make_steps() {
  const fs::path folder = fs::temp_directory_path() / "hrp_diagnosis_closest_findings";
  fs::create_directories(folder);
  std::ofstream(folder / "robot.urdf") << kLever;
  write_step(folder / "rise.csv", 0.0, 1.5);
  write_step(folder / "fall.csv", 1.5, 0.0);
  std::ofstream(folder / "experiment.yaml")
      << "robot: robot.urdf\nbase: fixed\nservo: {default: {kp: 8, kd: 0.05, effort_limit: 8}}\n"
         "recordings:\n- {file: rise.csv, role: train}\n- {file: fall.csv, role: validate}\n";
  Experiment e = load_experiment((folder / "experiment.yaml").string());
  const Hypothesis hidden{{EffectId::kViscous, 0, {kDrag}}, {EffectId::kDelay, 0, {kLate}}};
  double phase = 0.0;
  for (Recording& recording : e.recordings) {
    SmoothRecording still = smooth_recording(e, recording);
    still.start = 0;
    RolloutOptions fine;
    fine.max_step = 0.0002;
    fine.free_running = true;
    std::vector<double> y;
    EXPECT_TRUE(simulate_recording(make_plant(e, hidden), recording, still, fine, &y));
    for (size_t k = 0; k < recording.size(); ++k) {
      const double turn = kShaking * recording.time[k] + phase;
      recording.joints[0].signal[0][k] =
          kEncoder * std::round((y[k * kQuantities] + kShaken * std::sin(turn)) / kEncoder);
    }
    phase += 1.0;  // [rad]
  }
  e.joint_noise[0][0].sigma = kEncoder / std::sqrt(12.0);
  return e;
}

const Json* find_finding(const Json& report, const std::string& effect) {
  for (const Json& f : report["findings"]) {
    if (f["effect"] == effect) return &f;
  }
  return nullptr;
}

TEST(ClosestFindings, OfAShakenServoAreTheFrictionAndTheLateCommandWithTheirValues) {
  const Json report = diagnose_recordings(
                          make_steps(), {}, [](const std::string&) {}, [](const Reports&) {})
                          .report;
  EXPECT_EQ(report["verdict"], "mostly_explained") << report.dump(1);
  const Json *drag = find_finding(report, "viscous_friction"), *late = find_finding(report, "command_delay");
  ASSERT_TRUE(drag && late) << report["findings"].dump(1);
  // A tenth: what shakes the bench is fitted as well.
  EXPECT_NEAR((*drag)["parameters"]["coefficient"]["value"].get<double>(), kDrag, 0.1 * kDrag);
  EXPECT_NEAR((*late)["parameters"]["delay"]["value"].get<double>(), kLate, 0.1 * kLate);
  for (const Json& f : report["findings"]) {
    EXPECT_EQ(f["grade"], "ambiguous");
    for (const auto& p : f["parameters"].items()) EXPECT_GT(p.value()["std"].get<double>(), 0.0) << p.key();
  }
  ASSERT_FALSE(report["unexplained"].empty());
  EXPECT_THAT((*drag)["statement"].get<std::string>(), HasSubstr("another cause"));
  EXPECT_THAT(report["summary"].get<std::string>(), StartsWith("With "));
  EXPECT_THAT(report["summary"].get<std::string>(), HasSubstr("rad"));
}

}  // namespace
}  // namespace hrp::diagnosis
