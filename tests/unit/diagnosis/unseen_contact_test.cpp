// SPDX-License-Identifier: BSD-3-Clause
// A leg that hops on a rail, on ground whose force nobody recorded.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "diagnosis/evidence/torque/findings.h"
#include "tests/unit/diagnosis/torque_verdicts.h"

namespace hrp::diagnosis {
namespace {

namespace fs = std::filesystem;

// A body of 3 kg on a vertical rail, with a leg of 1 kg on a hip that swings about the horizontal.
constexpr double kBody = 3.0, kLeg = 1.0, kCenter = 0.15, kFoot = 0.3, kInertia = 0.01;  // [kg, kg, m, m, kg m^2]
constexpr double kDry = 0.2, kViscous = 0.06, kRotor = 0.02, kGravity = 9.81;            // [N m], [N m s/rad], [kg m^2]
constexpr const char* kHopper = R"(<robot name="hopper"><link name="stand"/>
  <link name="body"><inertial><mass value="3"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
  <link name="leg"><inertial><origin xyz="0 0 -0.15"/><mass value="1"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.001"/></inertial></link>
  <joint name="rail" type="prismatic"><parent link="stand"/><child link="body"/><axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="0" velocity="10"/></joint>
  <joint name="hip" type="revolute"><parent link="body"/><child link="leg"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="50" velocity="50"/></joint></robot>)";

// 12 s at 500 Hz. Each hop of 0.6 s has a flight of 0.36 s and a push of the ground that is a half sine. `supported`: a
// spring of the rail carries the weight instead, and the body swings on it.
void write_hops(const fs::path& file, double phase, bool supported) {
  constexpr double kStep = 1e-4, kHop = 0.6, kStance = 0.24;
  const double total = kBody + kLeg;
  TestNoise noise;
  std::ofstream csv(file);
  csv.precision(9);
  csv << "time,/joint_states/rail/position,/joint_states/hip/position,/joint_states/hip/effort\n";
  double z = 0.0, vz = supported ? 0.4 : -0.5 * kGravity * (kHop - kStance);
  for (int k = 0; k < 120000; ++k) {
    const double t = k * kStep, in_hop = std::fmod(t, kHop);
    const double q = 0.5 * std::sin(7.0 * t + phase) + 0.3 * std::sin(16.3 * t),
                 v = 3.5 * std::cos(7.0 * t + phase) + 4.89 * std::cos(16.3 * t);
    const double a = -24.5 * std::sin(7.0 * t + phase) - 79.7 * std::sin(16.3 * t);
    // the ground's force holds the momentum of a hop, that of the leg's own swing included
    const double swing = kLeg * kCenter * (std::sin(q) * a + std::cos(q) * v * v);
    const double push =
        in_hop < kStance ? total * kGravity * kHop / kStance * 0.5 * M_PI * std::sin(M_PI * in_hop / kStance) : 0.0;
    const double force = supported ? total * kGravity - 400.0 * z : push;
    const double az = (force - swing) / total - kGravity;
    const double friction = kDry * std::tanh(v / 0.01) + kViscous * v + kRotor * a;
    const double bodies = (kInertia + kLeg * kCenter * kCenter) * a + kLeg * kCenter * std::sin(q) * (kGravity + az);
    const double of_ground = supported ? 0.0 : -push * kFoot * std::sin(q);
    if (k % 20 == 0)
      csv << t << "," << z + 1e-5 * noise.draw() << "," << q + 2e-5 * noise.draw() << ","
          << bodies + friction + of_ground + 0.005 * noise.draw() << "\n";
    vz += kStep * az;
    z += kStep * vz;
  }
}

Experiment make_hops(const std::string& name, bool supported) {
  const fs::path folder = fs::temp_directory_path() / ("hrp_hops_" + name);
  fs::create_directories(folder);
  std::ofstream(folder / "robot.urdf") << kHopper;
  for (int r = 0; r < 2; ++r) write_hops(folder / ("r" + std::to_string(r) + ".csv"), 0.4 * r, supported);
  std::ofstream(folder / "experiment.yaml")
      << "robot: robot.urdf\nbase: fixed\ndrive: effort\nunactuated: [rail]\nrecordings:\n"
         "- {file: r0.csv, role: train}\n- {file: r1.csv, role: validate}\n";
  return load_experiment((folder / "experiment.yaml").string());
}

bool warns_of_ground(const TorqueVerdict& verdict) {
  const auto& list = verdict.evidence.warnings;
  return std::any_of(list.begin(), list.end(),
                     [](const std::string& w) { return w.find("pushes and lets go") != std::string::npos; });
}

// Before: a spring of the rail, a constant torque and a wrong zero of the hip, all supported.
TEST(UnseenContact, OfARobotThatHopsOnGroundOfUnknownForceOnlyTheFlightIsJudged) {
  const TorqueVerdict verdict = judge_torque(make_hops("ground", false), 1);
  EXPECT_TRUE(warns_of_ground(verdict));
  for (const Finding& f : verdict.evidence.findings) {
    EXPECT_TRUE(f.grade != Grade::kSupported || f.family == get_family_name(EffectFamily::kDryFriction) ||
                f.family == get_family_name(get_effect(EffectId::kViscous).family) ||
                f.family == get_family_name(get_effect(EffectId::kRotorInertia).family))
        << f.statement;
  }
  const Finding* dry = find(verdict, "coulomb_friction", "hip");
  ASSERT_NE(dry, nullptr);
  EXPECT_NEAR(dry->parameters[0].value[0], kDry, std::max(0.1 * kDry, 1.96 * dry->parameters[0].std[0]))
      << dry->statement;
}

// A spring pulls as well as it pushes.
TEST(UnseenContact, ASpringThatCarriesTheRobotIsNoGround) {
  const TorqueVerdict verdict = judge_torque(make_hops("spring", true), 1);
  EXPECT_FALSE(warns_of_ground(verdict));
  const Finding* spring = find(verdict, "parallel_spring", "rail");
  ASSERT_NE(spring, nullptr);
  EXPECT_NEAR(spring->parameters[0].value[0], 400.0, 20.0) << spring->statement;
}

}  // namespace
}  // namespace hrp::diagnosis
