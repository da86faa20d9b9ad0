// SPDX-License-Identifier: BSD-3-Clause
// Experiments whose recordings come from the tool's own rollout: what was put in must come out.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {

// An arm of two joints about y.
constexpr const char* kArm = R"(<robot name="arm"><link name="base"/>
  <link name="upper"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.03"/></inertial></link>
  <link name="fore"><inertial><origin xyz="0.15 0 0"/><mass value="1"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="50" velocity="10"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.4 0 0"/>
    <axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="50" velocity="10"/></joint></robot>)";
inline const std::vector<std::string> kArmJoints{"shoulder", "elbow"};
constexpr int kShoulder = 0, kElbow = 1, kFore = 2;  // joints; a link

// Friction and rotors of its drives.
inline Hypothesis make_arm_drives() {
  return {{EffectId::kViscous, kShoulder, {0.8}},         {EffectId::kCoulomb, kShoulder, {1.5, 0.0, 5e-4}},
          {EffectId::kRotorInertia, kShoulder, {0.6}},    {EffectId::kViscous, kElbow, {0.4}},
          {EffectId::kCoulomb, kElbow, {0.8, 0.0, 5e-4}}, {EffectId::kRotorInertia, kElbow, {0.3}}};
}

// Normally distributed enough: a sum of twelve uniforms, standard deviation 1.
class TestNoise {
 public:
  double draw() {
    double s = -6.0;
    for (int i = 0; i < 12; ++i) s += static_cast<double>((state_ = state_ * 1664525u + 1013904223u) >> 8) / 16777216.0;
    return s;
  }

 private:
  unsigned state_ = 12345;
};

// Smooth commands for all joints; the states' columns are replaced by simulated ones later.
inline void write_commands(const std::filesystem::path& path, const std::vector<std::string>& joints, int recording) {
  std::ofstream csv(path);
  csv.precision(12);
  csv << "time";
  for (const std::string& j : joints) {
    csv << ",/joint_commands/" << j << "/position,/joint_commands/" << j << "/velocity";
    for (const char* quantity : {"position", "velocity", "effort"}) csv << ",/joint_states/" << j << "/" << quantity;
  }
  for (int k = 0; k < 1200; ++k) {
    const double t = 0.005 * k;
    csv << "\n" << t;
    for (size_t j = 0; j < joints.size(); ++j) {
      const double w = 1.5 + recording + 0.4 * static_cast<double>(j);
      const double command = 0.6 * std::sin(w * t) * std::sin(0.5 * t);
      const double rate = 0.6 * (w * std::cos(w * t) * std::sin(0.5 * t) + 0.5 * std::sin(w * t) * std::cos(0.5 * t));
      csv << "," << command << "," << rate << "," << command << "," << rate << "," << command;
    }
  }
  csv << "\n";
}

// Three recordings of 6 s at 200 Hz, the last one held out, simulated with `hidden`, with little noise. Every joint's
// servo is 200 N m/rad, 10 N m s/rad.
inline Experiment make_simulated_experiment(const std::string& name, const std::string& urdf,
                                            const std::vector<std::string>& joints, const Hypothesis& hidden) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("hrp_diagnosis_" + name);
  fs::create_directories(folder);
  std::ofstream(folder / "robot.urdf") << urdf;
  std::string yaml =
      "robot: robot.urdf\nbase: fixed\nservo: {default: {kp: 200, kd: 10, effort_limit: 50}}\n"
      "noise: {position: 2.0e-5, velocity: 0.002, effort: 0.02}\nrecordings:\n";
  for (int r = 0; r < 3; ++r) {
    write_commands(folder / ("r" + std::to_string(r) + ".csv"), joints, r);
    yaml += "- {file: r" + std::to_string(r) + ".csv, role: " + (r < 2 ? "train" : "validate") + "}\n";
  }
  std::ofstream(folder / "experiment.yaml") << yaml;
  Experiment e = load_experiment((folder / "experiment.yaml").string());
  const size_t width = static_cast<size_t>(e.num_joints()) * kQuantities;
  for (Recording& recording : e.recordings) {
    SmoothRecording still = smooth_recording(e, recording);
    std::vector<double> y;
    RolloutOptions fine;
    fine.max_step = 0.0002;
    fine.free_running = true;  // nothing draws a robot to its commands, at a limit neither
    still.start = 0;
    EXPECT_TRUE(simulate_recording(make_plant(e, hidden), recording, still, fine, &y));
    TestNoise noise;
    const double sigma[] = {2e-5, 0.002, 0.02};
    for (size_t k = 0; k < recording.size(); ++k) {
      for (size_t c = 0; c < width; ++c)
        recording.joints[c / kQuantities].signal[c % kQuantities][k] =
            y[k * width + c] + sigma[c % kQuantities] * noise.draw();
    }
  }
  return e;
}

inline Experiment simulate_arm(const std::string& name, const Hypothesis& hidden) {
  return make_simulated_experiment(name, kArm, kArmJoints, hidden);
}

// An arm of these joints driven by efforts that are logged in other units; `torque_of_unit` [N m] of one, by joint.
inline Experiment simulate_currents(const std::string& name, const std::string& urdf, const Hypothesis& hidden,
                                    const std::vector<double>& torque_of_unit) {
  Experiment e = make_simulated_experiment(name, urdf, kArmJoints, hidden);
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) {
    for (size_t j = 0; j < r.joints.size(); ++j) {
      for (double& y : r.joints[j].signal[2]) y /= torque_of_unit[j];
    }
  }
  return e;
}

inline Experiment simulate_currents(const std::string& name, const Hypothesis& hidden,
                                    const std::vector<double>& torque_of_unit) {
  return simulate_currents(name, kArm, hidden, torque_of_unit);
}

// A description that states no limits of effort.
inline void remove_effort_limits(Experiment* e) {
  for (auto& link : e->robot.tree.links) link.joint.effort_limit = std::numeric_limits<double>::infinity();
  e->scenario.servo_default.effort_limit = std::numeric_limits<double>::infinity();
  for (auto& [name, gains] : e->scenario.servo_joints) gains.effort_limit = std::numeric_limits<double>::infinity();
}

}  // namespace hrp::diagnosis
