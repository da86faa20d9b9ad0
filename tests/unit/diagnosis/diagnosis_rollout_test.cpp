// SPDX-License-Identifier: BSD-3-Clause
// The rollout and the fit on a pendulum made here: what was put in comes out.
#include <cmath>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "diagnosis/report/report.h"

namespace hrp::diagnosis {
namespace {

namespace fs = std::filesystem;

constexpr const char* kUrdf = R"(<robot name="arm"><link name="base"/><link name="l1"><inertial><origin xyz="0 0 -0.2"/>
<mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial></link>
<joint name="j1" type="revolute"><parent link="base"/><child link="l1"/><origin xyz="0 0 0"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="50" velocity="10"/></joint></robot>)";

// An experiment whose recordings come from the rollout with `hidden`, at 200 Hz with a smooth command and little noise.
Experiment make_experiment(const std::string& name, const Hypothesis& hidden) {
  const fs::path folder = fs::temp_directory_path() / ("hrp_diagnosis_" + name);
  fs::create_directories(folder);
  std::ofstream(folder / "robot.urdf") << kUrdf;
  std::string yaml = "robot: robot.urdf\nbase: fixed\nservo: {default: {kp: 200, kd: 10, effort_limit: 50}}\n"
                     "noise: {position: 2.0e-5, velocity: 0.002, effort: 0.02}\nrecordings:\n";
  for (int r = 0; r < 3; ++r) {
    std::ofstream csv(folder / ("r" + std::to_string(r) + ".csv"));
    csv.precision(12);
    csv << "time,/joint_commands/j1/position,/joint_commands/j1/velocity,/joint_states/j1/position,/joint_states/j1/velocity,/joint_states/j1/effort\n";
    for (int k = 0; k < 1200; ++k) {
      const double t = 0.005 * k, w = 1.5 + r;
      const double command = 0.6 * std::sin(w * t) * std::sin(0.5 * t);
      const double rate = 0.6 * (w * std::cos(w * t) * std::sin(0.5 * t) + 0.5 * std::sin(w * t) * std::cos(0.5 * t));
      // Readings that are replaced below, near what a robot would do.
      csv << t << "," << command << "," << rate << "," << command << "," << rate << "," << command << "\n";
    }
    yaml += "- {file: r" + std::to_string(r) + ".csv, role: " + (r < 2 ? "train" : "validate") + "}\n";
  }
  std::ofstream(folder / "experiment.yaml") << yaml;
  Experiment e = load_experiment((folder / "experiment.yaml").string());
  for (Recording& recording : e.recordings) {
    SmoothRecording still = smooth_recording(e, recording);
    std::vector<double> y;
    Plant plant = make_plant(e, hidden);
    RolloutOptions fine;
    fine.max_step = 0.0002;
    still.start = 0;
    EXPECT_TRUE(simulate_recording(plant, recording, still, fine, &y));
    unsigned state = 12345;
    const auto noise = [&] {   // sum of uniforms, standard deviation 1
      double s = -6.0;
      for (int i = 0; i < 12; ++i) s += static_cast<double>((state = state * 1664525u + 1013904223u) >> 8) / 16777216.0;
      return s;
    };
    const double sigma[] = {2e-5, 0.002, 0.02};
    for (size_t k = 0; k < recording.size(); ++k) {
      for (int q = 0; q < kQuantities; ++q) recording.joints[0].signal[q][k] = y[k * 3 + static_cast<size_t>(q)] + sigma[q] * noise();
    }
  }
  return e;
}

TEST(Diagnosis, FindsNothingWhereNothingIsHidden) {
  const Experiment e = make_experiment("none", {});
  const Problem problem = make_problem(e, 1);
  const Outcome outcome = search(problem, [](const std::string&) {});
  EXPECT_FALSE(outcome.mismatch);
  EXPECT_NEAR(outcome.nominal.rms, 1.0, 0.05);   // 3600 readings: 1.2 % of chance, start of the rollout
}

TEST(Diagnosis, RecoversViscousFriction) {
  const Experiment e = make_experiment("viscous", {{EffectId::kViscous, 0, {0.7}}});
  const Problem problem = make_problem(e, 1);
  const Outcome outcome = search(problem, [](const std::string&) {});
  ASSERT_TRUE(outcome.explained);
  ASSERT_EQ(outcome.chosen.hypothesis.size(), 1u);
  EXPECT_EQ(outcome.chosen.hypothesis[0].id, EffectId::kViscous);
  EXPECT_NEAR(outcome.chosen.hypothesis[0].p[0], 0.7, 0.01);
  EXPECT_LT(outcome.chosen.rms, 1.2);
}

TEST(Diagnosis, DoesNotDependOnTheNumberOfThreads) {
  const Experiment e = make_experiment("threads", {{EffectId::kRotorInertia, 0, {0.05}}});
  Reports reports[2];
  for (int jobs = 1; jobs <= 2; ++jobs) {
    const Problem problem = make_problem(e, jobs);
    reports[jobs - 1] = diagnose(problem, [](const std::string&) {});
  }
  EXPECT_EQ(reports[0].report.dump(), reports[1].report.dump());
  EXPECT_EQ(reports[0].report["findings"][0]["effect"], "rotor_inertia");
}

}  // namespace
}  // namespace hrp::diagnosis
