// SPDX-License-Identifier: BSD-3-Clause
// Arms of six joints with measured torque, like those of laboratories and factories: drives that differ by a factor of
// fifty from shoulder to wrist, texture of friction over position, torque ripple, masses and inertias that are a little
// wrong.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "diagnosis/evidence/torque/findings.h"
#include "diagnosis/findings/families.h"
#include "diagnosis/simulation/bodies.h"
#include "tests/unit/diagnosis/joint_sines.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

constexpr int kJoints = 6, kRecordings = 3;
constexpr double kStep = 0.005, kSeconds = 15.0;

struct Part {
  const char *origin, *rpy;
  double mass, com[3], inertia[3];
  double dry, viscous, rotor;  // [N m], [N m s/rad], [kg m^2] of the drive before it
};

const Part kParts[kJoints] = {
    {"0 0 0.09", "0 0 0", 3.8, {0.0, 0.0, -0.02}, {0.010, 0.010, 0.007}, 9.0, 11.0, 3.7},
    {"0 0.14 0", "-1.5708 0 0", 8.4, {0.21, 0.0, 0.0}, {0.015, 0.13, 0.13}, 12.0, 14.0, 3.7},
    {"0.42 0 -0.12", "0 0 0", 2.3, {0.20, 0.0, 0.0}, {0.004, 0.031, 0.031}, 7.0, 8.0, 2.2},
    {"0.39 0 0", "0 0 0", 1.2, {0.0, 0.0, 0.01}, {0.0026, 0.0026, 0.0022}, 2.2, 2.1, 0.45},
    {"0 0 0.09", "1.5708 0 0", 1.2, {0.0, 0.0, 0.01}, {0.0026, 0.0026, 0.0022}, 2.0, 1.9, 0.45},
    {"0 0 0.09", "-1.5708 0 0", 0.2, {0.0, 0.0, -0.02}, {1e-4, 1e-4, 1.3e-4}, 1.8, 1.6, 0.45}};

std::string get_joint(int j) { return "joint_" + std::to_string(j + 1); }

// Masses, centres of mass and inertias are off by up to `wrong`, one way and the other.
std::string make_urdf(double wrong) {
  std::ostringstream s;
  s << "<robot name=\"arm\"><link name=\"base\"/>";
  for (int j = 0; j < kJoints; ++j) {
    const Part& p = kParts[j];
    const double factor = 1.0 + wrong * std::cos(2.3 * j), aside = 1.0 + wrong * std::sin(1.7 * j + 1.0);
    s << "<link name=\"link_" << j + 1 << "\"><inertial><origin xyz=\"" << aside * p.com[0] << " " << aside * p.com[1]
      << " " << aside * p.com[2] << "\"/><mass value=\"" << factor * p.mass << "\"/><inertia ixx=\""
      << aside * p.inertia[0] << "\" ixy=\"0\" ixz=\"0\" iyy=\"" << aside * p.inertia[1] << "\" iyz=\"0\" izz=\""
      << aside * p.inertia[2] << "\"/></inertial></link><joint name=\"" << get_joint(j)
      << "\" type=\"revolute\"><parent link=\"" << (j == 0 ? "base" : "link_" + std::to_string(j))
      << "\"/><child link=\"link_" << j + 1 << "\"/><origin xyz=\"" << p.origin << "\" rpy=\"" << p.rpy
      << "\"/><axis xyz=\"0 0 1\"/><limit lower=\"-3\" upper=\"3\" effort=\"150\" velocity=\"3\"/></joint>";
  }
  s << "</robot>";
  return s.str();
}

Experiment load(const std::filesystem::path& folder, const std::string& urdf) {
  std::ofstream(folder / "robot.urdf") << urdf;
  return load_experiment((folder / "experiment.yaml").string());
}

using Motion = JointMotion;

Motion make_motion(int recording) {
  return make_joint_sines({kJoints, kStep, kSeconds, 0.55, 0.09, 0.45, [](int j) { return 0.3 * std::sin(1.0 + j); }},
                          recording);
}

// What drives give: bodies, losses with a texture of a tenth over position, rotors; and ripple of a fiftieth in the
// log.
Eigen::MatrixXd make_efforts(const Plant& bodies, const Motion& m, TestNoise* noise) {
  Eigen::MatrixXd tau = calc_efforts(bodies, m.q, m.v, m.a);
  for (int j = 0; j < kJoints; ++j) {
    const Part& p = kParts[j];
    const double spread = std::sqrt((tau.col(j).array() - tau.col(j).mean()).square().mean()) + p.dry;
    for (long k = 0; k < tau.rows(); ++k) {
      const double dry = p.dry * (1.0 + 0.1 * std::sin(5.0 * m.q(k, j) + j));
      tau(k, j) += dry * std::tanh(m.v(k, j) / 0.002) + p.viscous * m.v(k, j) + p.rotor * m.a(k, j) +
                   spread * (0.02 * std::sin(120.0 * m.q(k, j)) + 0.02 * noise->draw());
    }
  }
  return tau;
}

void write_recording(const std::filesystem::path& path, const Motion& m, const Eigen::MatrixXd& effort) {
  constexpr double kResolution = 2e-5;  // [rad] 18 bits
  std::ofstream csv(path);
  csv.precision(9);
  csv << "time";
  for (int j = 0; j < kJoints; ++j)
    csv << ",/joint_states/" << get_joint(j) << "/position,/joint_states/" << get_joint(j) << "/effort";
  for (long k = 0; k < m.q.rows(); ++k) {
    csv << "\n" << kStep * static_cast<double>(k);
    for (int j = 0; j < kJoints; ++j)
      csv << "," << kResolution * std::round(m.q(k, j) / kResolution) << "," << effort(k, j);
  }
  csv << "\n";
}

Experiment make_arm(const std::string& name, double wrong) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("hrp_serial_arm_" + name);
  std::filesystem::create_directories(folder);
  std::string yaml = "robot: robot.urdf\nbase: fixed\ndrive: effort\nrecordings:\n";
  TestNoise noise;
  for (int r = 0; r < kRecordings; ++r) {
    const std::string file = "r" + std::to_string(r) + ".csv";
    yaml += "- {file: " + file + ", role: " + (r + 1 < kRecordings ? "train" : "validate") + "}\n";
    const Motion m = make_motion(r);
    write_recording(folder / file, m, Eigen::MatrixXd::Zero(m.q.rows(), kJoints));
  }
  std::ofstream(folder / "experiment.yaml") << yaml;
  const Plant bodies = make_plant(load(folder, make_urdf(0.0)), {});
  for (int r = 0; r < kRecordings; ++r) {
    const Motion m = make_motion(r);
    write_recording(folder / ("r" + std::to_string(r) + ".csv"), m, make_efforts(bodies, m, &noise));
  }
  return load(folder, make_urdf(wrong));
}

const Finding* find_family(const TorqueVerdict& verdict, EffectFamily family, const std::string& joint) {
  for (const Finding& f : verdict.evidence.findings) {
    if (f.family == get_family_name(family) && f.where.contains("joint") && f.where.at("joint") == joint) return &f;
  }
  return nullptr;
}

TEST(SerialArms, DryFrictionOfEveryJointIsSupportedBesideMassesThatAreATenthOff) {
  const TorqueVerdict verdict = judge_torque(make_arm("dry", 0.1), 2);
  for (int j = 0; j < kJoints; ++j) {
    const Finding* dry = find_family(verdict, EffectFamily::kDryFriction, get_joint(j));
    ASSERT_NE(dry, nullptr) << get_joint(j);
    EXPECT_EQ(dry->grade, Grade::kSupported) << dry->statement;
    if (dry->effect != "coulomb_friction") continue;  // grows with load or falls with speed: other parameters
    // 15 %: a texture of a tenth, which no term has.
    EXPECT_NEAR(dry->parameters[0].value[0], kParts[j].dry, 0.15 * kParts[j].dry) << dry->statement;
  }
}

TEST(SerialArms, NoPayloadForceOrRippleIsSupportedInThePlaceOfFriction) {
  const TorqueVerdict verdict = judge_torque(make_arm("dry", 0.1), 2);
  for (const Finding& f : verdict.evidence.findings) {
    const bool other = f.effect == "payload" || f.effect == "external_force" || f.effect == "cogging";
    EXPECT_FALSE(other && f.grade == Grade::kSupported) << f.statement;
  }
}

}  // namespace
}  // namespace hrp::diagnosis
