// SPDX-License-Identifier: BSD-3-Clause
// make_long_recordings FOLDER JOINTS SECONDS RATE COUNT [servo]: an experiment with long recordings, to measure what a
// diagnosis of them costs. With `servo` commands of a stiff servo are recorded, too. A tree of limbs of six joints;
// every joint has dry and viscous friction and a rotor that the URDF lacks. It moves for 20 s, rests for 10 s, and so
// on, as robots do that are recorded for long.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "common/multibody/inverse_dynamics.h"
#include "common/multibody/kinematics.h"
#include "servers/model_parser/robot_loader.h"

namespace {

using namespace hrp;
constexpr int kLimb = 6;
constexpr double kGain = 800.0;  // [N m/rad] of the servo

std::string make_urdf(int joints) {
  std::string urdf = "<robot name='long'><link name='base'/>";
  for (int j = 0; j < joints; ++j) {
    const std::string name = std::to_string(j), parent = j % kLimb == 0 ? "base" : "l" + std::to_string(j - 1);
    const char* const axes[] = {"0 1 0", "1 0 0", "0 0 1"};
    urdf += "<link name='l" + name + "'><inertial><origin xyz='0.02 0.03 -0.1'/><mass value='" +
            std::to_string(3.0 - 0.3 * (j % kLimb)) +
            "'/><inertia ixx='0.02' ixy='0' ixz='0' iyy='0.02' iyz='0' izz='0.01'/></inertial></link><joint name='j" +
            name + "' type='revolute'><parent link='" + parent + "'/><child link='l" + name + "'/><origin xyz='0 " +
            std::to_string(j % kLimb == 0 ? 0.1 * j : 0.0) + " -0.2'/><axis xyz='" + axes[j % 3] +
            "'/><limit lower='-3' upper='3' effort='200' velocity='20'/></joint>";
  }
  return urdf + "</robot>";
}

// Sums of three sines, which fade in and out.
struct Motion {
  double q = 0.0, v = 0.0, a = 0.0;
};
Motion move(int joint, int recording, double t) {
  Motion m;
  const double phase = std::fmod(t, 30.0), w = M_PI / 20.0;
  if (phase >= 20.0) return m;
  const double s = std::sin(w * phase) * std::sin(w * phase), sd = w * std::sin(2 * w * phase),
               sdd = 2 * w * w * std::cos(2 * w * phase);
  double y = 0.0, yd = 0.0, ydd = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double f = 2 * M_PI * (0.2 + 0.25 * i + 0.013 * joint + 0.02 * recording), p = 1.3 * joint + i,
                 A = 0.3 / (1 + i);
    y += A * std::sin(f * t + p);
    yd += A * f * std::cos(f * t + p);
    ydd -= A * f * f * std::sin(f * t + p);
  }
  m.q = s * y;
  m.v = sd * y + s * yd;
  m.a = sdd * y + 2 * sd * yd + s * ydd;
  return m;
}

void write_recording(const std::filesystem::path& path, const TreeSpec& tree, int recording, double seconds,
                     double rate, bool servo) {
  std::mt19937 random(static_cast<unsigned>(recording) + 1);
  std::normal_distribution<double> normal;
  const Model model(tree, {0, 0, -9.81});
  Data data(model);
  State state = make_state(model);
  std::FILE* file = std::fopen(path.c_str(), "w");
  std::fputs("time", file);
  for (int j = 0; j < tree.num_joints() && servo; ++j) std::fprintf(file, ",/joint_commands/j%d/position", j);
  for (int j = 0; j < tree.num_joints(); ++j)
    std::fprintf(file, ",/joint_states/j%d/position,/joint_states/j%d/velocity,/joint_states/j%d/effort", j, j, j);
  Eigen::VectorXd a(tree.num_joints()), tau(tree.num_joints());
  for (long k = 0; k < std::lround(seconds * rate); ++k) {
    const double t = static_cast<double>(k) / rate;
    for (int j = 0; j < tree.num_joints(); ++j) {
      const Motion m = move(j, recording, t);
      state.q[j] = m.q;
      state.qd[j] = m.v;
      a[j] = m.a;
    }
    update_kinematics(model, state, &data);
    calc_inverse_dynamics(model, a, nullptr, &data, &tau);
    std::fprintf(file, "\n%.6f", t);
    const auto find_hidden = [&](int j) {
      return 0.05 * a[j] + 0.2 * state.qd[j] + (0.4 + 0.02 * j) * std::tanh(state.qd[j] / 0.005);
    };
    for (int j = 0; j < tree.num_joints() && servo; ++j)
      std::fprintf(file, ",%.7f", state.q[j] + (tau[j] + find_hidden(j)) / kGain);
    for (int j = 0; j < tree.num_joints(); ++j) {
      const double hidden = find_hidden(j);
      std::fprintf(file, ",%.6f,%.5f,%.4f", state.q[j] + 2e-5 * normal(random), state.qd[j] + 2e-3 * normal(random),
                   tau[j] + hidden + 0.05 * normal(random));
    }
  }
  std::fputs("\n", file);
  std::fclose(file);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 6) {
    std::fprintf(stderr, "usage: make_long_recordings FOLDER JOINTS SECONDS RATE COUNT [servo]\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  const int joints = std::atoi(argv[2]), count = std::atoi(argv[5]);
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "robot.urdf") << make_urdf(joints);
  std::ofstream yaml(folder / "experiment.yaml");
  const bool servo = argc > 6;
  yaml << "robot: robot.urdf\nbase: fixed\n"
       << (servo ? "servo: {default: {kp: " + std::to_string(kGain) + ", kd: 0}}\n" : "drive: effort\n")
       << "recordings:\n";
  for (int r = 0; r < count; ++r)
    yaml << "  - {file: r" << r << ".csv, role: " << (r > 0 && r == count - 1 ? "validate" : "train") << "}\n";
  yaml.close();
  Scenario scenario = load_scenario((folder / "experiment.yaml").string());
  const RobotDescription robot = load_robot(scenario);
  for (int r = 0; r < count; ++r)
    write_recording(folder / ("r" + std::to_string(r) + ".csv"), robot.tree, r, std::atof(argv[3]), std::atof(argv[4]),
                    servo);
}
