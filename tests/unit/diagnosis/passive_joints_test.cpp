// SPDX-License-Identifier: BSD-3-Clause
// Joints that nothing drives, as of a pendulum that swings freely in front of an encoder.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "diagnosis/checks/checks.h"
#include "diagnosis/conventions/log_conventions.h"
#include "diagnosis/data/plausibility.h"
#include "diagnosis/evidence/torque/findings.h"
#include "diagnosis/search/missing.h"
#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {
namespace {

namespace fs = std::filesystem;

constexpr double kMass = 0.5, kLength = 0.3, kInertia = 0.006;  // [kg, m, kg m^2 about the centre of mass]
constexpr double kViscousFriction = 0.006, kDryFriction = 0.012, kRotor = 0.02;  // [N m s/rad, N m, kg m^2]
constexpr double kGravity = 9.81;

constexpr const char* kPendulum = R"(<robot name="pendulum"><link name="stand"/>
  <link name="rod"><inertial><origin xyz="0 0 -0.3"/><mass value="0.5"/>
    <inertia ixx="0.006" ixy="0" ixz="0" iyy="0.006" iyz="0" izz="0.0005"/></inertial></link>
  <joint name="hinge" type="continuous"><parent link="stand"/><child link="rod"/><axis xyz="0 1 0"/>
    <limit effort="1" velocity="100"/></joint></robot>)";

// Torque [N m] of a motor at the hinge, at time t [s].
using Torque = double (*)(double t);
double calc_none(double) { return 0.0; }
double calc_pushes(double t) { return 0.05 * std::sin(3.1 * t) + 0.04 * std::sin(9.7 * t); }
double calc_waves(double t) { return 0.8 * std::sin(2.1 * t) + 0.5 * std::sin(5.3 * t); }

// What differs between pendulums, and how they start.
struct Swing {
  double speed = 0.0, size = 1.0;     // [rad/s] at the start, and factor on its angles
  double rotor = kRotor, zero = 0.0;  // [kg m^2, rad] inertia beside the link's; the encoder reads that much too much
};

// Writes 20 s at 100 Hz by an encoder of 4096 steps a turn. `key`: column of the torque; empty for none.
void write_swing(const fs::path& file, double q, const Swing& swing, Torque torque, const std::string& key) {
  constexpr double kCount = 2.0 * M_PI / 4096.0, kStep = 1e-4;
  constexpr int kSteps = 100;  // a sample
  const double about_hinge = kInertia + kMass * kLength * kLength + swing.rotor;
  double qd = swing.speed;
  std::ofstream csv(file);
  csv << "time,/joint_states/hinge/position" << (key.empty() ? "" : ",") << key << "\n";
  for (int k = 0; k < 2000 * kSteps; ++k) {
    const double t = k * kStep;
    if (k % kSteps == 0) {
      csv << t << "," << kCount * std::round((q + swing.zero) / kCount);
      if (!key.empty()) csv << "," << torque(t);
      csv << "\n";
    }
    const double friction = kViscousFriction * qd + kDryFriction * std::tanh(qd / 0.002);
    qd +=
        kStep * (torque(t) - friction - kMass * kGravity * kLength * std::sin(q)) / about_hinge;  // semi-implicit Euler
    q += kStep * qd;
  }
}

Experiment make_experiment(const std::string& name, Torque torque, const std::string& key, const std::string& keys,
                           const Swing& swing = {}) {
  const fs::path folder = fs::temp_directory_path() / ("hrp_passive_" + name);
  fs::create_directories(folder);
  std::ofstream(folder / "robot.urdf") << kPendulum;
  const double starts[] = {1.6, 2.6, 1.0};
  std::string yaml = "robot: robot.urdf\nbase: fixed\ndrive: effort\n" + keys + "recordings:\n";
  for (int r = 0; r < 3; ++r) {
    const std::string file = "r" + std::to_string(r) + ".csv";
    write_swing(folder / file, swing.size * starts[r], swing, torque, key);
    yaml += "- {file: " + file + ", role: " + (r < 2 ? "train" : "validate") + "}\n";
  }
  std::ofstream(folder / "experiment.yaml") << yaml;
  return load_experiment((folder / "experiment.yaml").string());
}

// A pole on a cart that a hand pushes to and fro: the log has the cart's position and the pole's angle [rad].
constexpr const char* kCart = R"(<robot name="cart"><link name="rail"/>
  <link name="cart"><inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
  <link name="pole"><inertial><origin xyz="0 0 -0.3"/><mass value="0.5"/>
    <inertia ixx="0.006" ixy="0" ixz="0" iyy="0.006" iyz="0" izz="0.0005"/></inertial></link>
  <joint name="slide" type="prismatic"><parent link="rail"/><child link="cart"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" effort="10" velocity="10"/></joint>
  <joint name="hinge" type="continuous"><parent link="cart"/><child link="pole"/><axis xyz="0 1 0"/>
    <limit effort="1" velocity="100"/></joint></robot>)";

Experiment make_pushed_cart() {
  const fs::path folder = fs::temp_directory_path() / "hrp_passive_cart";
  fs::create_directories(folder);
  std::ofstream(folder / "robot.urdf") << kCart;
  constexpr double kStep = 1e-4, kMoment = kMass * kLength;
  std::string yaml = "robot: robot.urdf\nbase: fixed\ndrive: effort\nunactuated: [hinge]\nrecordings:\n";
  for (int r = 0; r < 2; ++r) {
    const std::string file = "r" + std::to_string(r) + ".csv";
    std::ofstream csv(folder / file);
    csv << "time,/joint_states/slide/position,/joint_states/hinge/position\n";
    const double slow = 3.0 + 0.4 * r, fast = 7.1 - 0.5 * r;  // [rad/s] of the hand
    double q = 0.3, qd = 0.0;
    for (int k = 0; k < 100000; ++k) {
      const double t = k * kStep, swing = 0.10 * std::sin(slow * t), shake = 0.03 * std::sin(fast * t);
      if (k % 100 == 0) csv << t << "," << swing + shake << "," << q << "\n";
      const double hand = -slow * slow * swing - fast * fast * shake;
      qd += kStep * (kMoment * (std::cos(q) * hand - kGravity * std::sin(q)) - kViscousFriction * qd) /
            (kInertia + kMoment * kLength);
      q += kStep * qd;
    }
    yaml += "- {file: " + file + ", unknown_force: [slide], role: " + (r < 1 ? "train" : "validate") + "}\n";
  }
  std::ofstream(folder / "experiment.yaml") << yaml;
  return load_experiment((folder / "experiment.yaml").string());
}

Experiment make_free_swing() { return make_experiment("swing", &calc_none, "", "unactuated: [hinge]\n"); }

const Finding* find(const TorqueVerdict& verdict, const std::string& effect) {
  for (const Finding& f : verdict.evidence.findings) {
    if (f.effect == effect) return &f;
  }
  return nullptr;
}

// A servo without power: its rotor turns with the pendulum. Before, a share of gravity and a moved centre of mass took
// mass and weight away, which explains any motion.
TEST(PassiveJoints, AFreePendulumHasFrictionAndARotorAndKeepsItsMass) {
  const TorqueVerdict verdict = judge_torque(make_free_swing(), 1);
  ASSERT_TRUE(verdict.judged);
  EXPECT_EQ(verdict.evidence.findings.size(), 3u);
  for (const auto& [effect, truth] : {std::pair{"viscous_friction", kViscousFriction},
                                      {"coulomb_friction", kDryFriction},
                                      {"rotor_inertia", kRotor}}) {
    const Finding* f = find(verdict, effect);
    ASSERT_NE(f, nullptr) << effect;
    // 15 %: the filtered encoder smears the reversals, at which the two laws differ.
    EXPECT_NEAR(f->parameters[0].value[0], truth, 0.15 * truth) << f->statement;
  }
}

// A free pole's report said that 0 N m were missing, which followed its position.
TEST(PassiveJoints, WhatIsMissingAtAJointWithoutADriveIsTheTorqueThatItsMotionTakes) {
  const Experiment e = make_free_swing();
  const MissingEffort m = calc_missing_effort(make_problem(e, 1), {}, 0);
  const double missing = std::sqrt(m.missing.squaredNorm() / static_cast<double>(m.missing.size()));
  EXPECT_GT(missing, kDryFriction);
  EXPECT_LT(missing, kMass * kGravity * kLength);
}

// At 60 rad/s its weight pulls with 10 Hz, which the filter takes out of the efforts, but not out of the sine of a
// filtered angle. Before, that sine was all that was missing.
TEST(PassiveJoints, OfAPendulumThatTurnsOverFasterThanTheFilterFrictionIsFound) {
  const TorqueVerdict verdict =
      judge_torque(make_experiment("over", &calc_none, "", "unactuated: [hinge]\n", {60.0}), 1);
  const Finding* f = find(verdict, "viscous_friction");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->grade, Grade::kSupported) << f->statement;
  // Dry friction is a tenth of it
  EXPECT_NEAR(f->parameters[0].value[0], kViscousFriction, 0.1 * kViscousFriction) << f->statement;
  EXPECT_GT(verdict.evidence.explained, 0.9);
}

// A free pendulum's angle accelerates in proportion to itself. A spring was named alone, where the link had less
// inertia than the model and the encoder another zero: neither fits without the other.
TEST(PassiveJoints, OfASmallSwingASpringIsNotToldFromLessInertia) {
  constexpr double kLess = 0.003;  // [kg m^2]
  const TorqueVerdict verdict =
      judge_torque(make_experiment("quick", &calc_none, "", "unactuated: [hinge]\n", {0.0, 0.15, -kLess, 0.02}), 1);
  const Finding* spring = find(verdict, "parallel_spring");
  ASSERT_NE(spring, nullptr);
  EXPECT_EQ(spring->grade, Grade::kAmbiguous) << spring->statement;
  const auto less = std::find_if(spring->alternatives.begin(), spring->alternatives.end(),
                                 [](const Alternative& a) { return a.effect == "inertia_error"; });
  ASSERT_NE(less, spring->alternatives.end()) << spring->statement;
  EXPECT_NEAR(less->parameters[0].value[0], 1.0 - kLess / kInertia, 0.15) << spring->statement;
}

// A free pendulum shows its inertia over its moment alone. A rotor at its hinge was `supported`, and named without the
// link's inertia or a longer rod, of which the model's makers may have known less.
TEST(PassiveJoints, ARotorAtAFreeHingeIsNotToldFromTheLinksInertia) {
  const TorqueVerdict verdict = judge_torque(make_free_swing(), 1);
  const Finding* rotor = find(verdict, "rotor_inertia");
  ASSERT_NE(rotor, nullptr);
  EXPECT_EQ(rotor->grade, Grade::kAmbiguous) << rotor->statement;
  const auto parameter = [&](const std::string& effect, int axis) {
    for (const Alternative& a : rotor->alternatives)
      if (a.effect == effect) return a.parameters[0].value[axis];
    return std::nan("");
  };
  EXPECT_NEAR(parameter("inertia_error", 0), (kInertia + kRotor) / kInertia, 0.5) << rotor->statement;
  const double length = kLength - parameter("com_error", 2);
  EXPECT_NEAR((kInertia + kMass * length * length) / (kMass * length),
              (kInertia + kRotor + kMass * kLength * kLength) / (kMass * kLength), 0.03)
      << rotor->statement;
}

// All of a model's mass at the end of its rod has no inertia to lose, but the rod may be shorter. A spring was
// `supported`.
TEST(PassiveJoints, OfASmallSwingASpringIsNotToldFromAShorterRod) {
  constexpr double kRod = 0.36, kPoint = 1e-5;  // [m, kg m^2] of the model
  Experiment e = make_experiment("short", &calc_none, "", "unactuated: [hinge]\n", {0.0, 0.15, 0.0, 0.02});
  LinkInertia& rod = e.robot.tree.links[1].inertia;
  rod.p_LLcm_L = Vector3d(0.0, 0.0, -kRod);
  rod.I_LLcm_L = kPoint * Matrix3d::Identity();
  const TorqueVerdict verdict = judge_torque(e, 1);
  const Finding* spring = find(verdict, "parallel_spring");
  ASSERT_NE(spring, nullptr);
  EXPECT_EQ(spring->grade, Grade::kAmbiguous) << spring->statement;
  const auto nearer = std::find_if(spring->alternatives.begin(), spring->alternatives.end(),
                                   [](const Alternative& a) { return a.effect == "com_error"; });
  ASSERT_NE(nearer, spring->alternatives.end()) << spring->statement;
  const double length =
      (kInertia + kMass * kLength * kLength) / (kMass * kLength);  // of a point mass that swings alike
  EXPECT_NEAR(kRod - nearer->parameters[0].value[2], length, 0.01) << spring->statement;
}

// True if a warning of the verdict on this experiment contains the word.
bool warns_of(const Experiment& e, const std::string& word) {
  const TorqueVerdict verdict = judge_torque(e, 1);
  return std::any_of(verdict.evidence.warnings.begin(), verdict.evidence.warnings.end(),
                     [&](const std::string& w) { return w.find(word) != std::string::npos; });
}

// The hand's force on the cart was taken for one on the pole: friction that the pole's swings show was doubted.
TEST(PassiveJoints, AHandThatPushesTheCartDoesNotHoldItsPole) {
  const TorqueVerdict verdict = judge_torque(make_pushed_cart(), 1);
  const Finding* friction = find(verdict, "viscous_friction");
  ASSERT_NE(friction, nullptr);
  EXPECT_EQ(friction->where["joint"], "hinge");
  EXPECT_EQ(friction->statement.find("another force"), std::string::npos) << friction->statement;
  EXPECT_NEAR(friction->parameters[0].value[0], kViscousFriction, 0.15 * kViscousFriction) << friction->statement;
  for (const std::string& warning : verdict.evidence.warnings)
    EXPECT_EQ(warning.find("by hand"), std::string::npos) << warning;
}

// In degrees its weight and inertia do not cancel, as if somebody moved it; and efforts that nothing can log were asked
// for.
TEST(PassiveJoints, AFreePendulumLoggedInDegreesIsSaidToBe) {
  Experiment e = make_experiment("degrees", &calc_none, "", "unactuated: [hinge]\n", {0.0, 0.05});
  EXPECT_FALSE(warns_of(e, "degrees"));
  for (Recording& r : e.recordings) {
    for (double& q : r.joints[0].signal[0]) q *= kDegrees;
  }
  EXPECT_TRUE(warns_of(e, "degrees"));
}

// The share of a passive torque that is left is small where the torque is large: a pendulum that hangs, pushed by a
// hand, was taken for one that lies, and refused.
TEST(PassiveJoints, APendulumThatIsPushedHangsAsTheModelSays) {
  const Experiment e = make_experiment("pushed", &calc_pushes, "", "unactuated: [hinge]\n", {0.0, 0.1});
  EXPECT_NO_THROW(find_conventions(e, 1));
}

TEST(PassiveJoints, ChecksDoNotSpeakOfADriveThatIsNotThere) {
  const Experiment e = make_free_swing();
  const nlohmann::json checks = make_checks(e, e);
  for (const nlohmann::json& tells : checks["joints"][0]["tells"]) {
    EXPECT_NE(tells["effect"], "torque_constant_error");
  }
  for (const std::string& warning : e.warnings) EXPECT_EQ(warning.find("effort"), std::string::npos) << warning;
}

// A sensor on the motor, and an encoder whose steps hide the motion: noise only adds to the rate of the position.
TEST(PassiveJoints, ChecksSayThatAVelocityIsMuchFasterThanACoarsePosition) {
  Experiment e = make_free_swing();
  const auto says = [&] {
    return make_checks(e, e)["remarks"].dump().find("so many times the rate of the position") != std::string::npos;
  };
  EXPECT_FALSE(says());
  for (Recording& r : e.recordings) {
    JointColumns& joint = r.joints[0];
    joint.signal[1].resize(r.size());
    for (size_t k = 0; k < r.size(); ++k) {
      joint.signal[0][k] = k % 7 < 3 ? 0.005 : 0.0;
      joint.signal[1][k] = 5.0 * std::sin(0.3 * static_cast<double>(k));
    }
  }
  EXPECT_TRUE(says());
}

TEST(PassiveJoints, ChecksSayThatNothingIsHeldOut) {
  Experiment e = make_free_swing();
  const auto says = [&] {
    return make_checks(e, e)["remarks"].dump().find("no recording is held out") != std::string::npos;
  };
  EXPECT_FALSE(says());
  for (Recording& r : e.recordings) r.spec.train = true;
  EXPECT_TRUE(says());
}

TEST(PassiveJoints, ACommandedEffortStandsInForOneThatWasNotLogged) {
  const std::string command = "/joint_commands/hinge/effort", state = "/joint_states/hinge/effort";
  const Experiment commanded = make_experiment("command", &calc_waves, command, ""),
                   logged = make_experiment("log", &calc_waves, state, "");
  const size_t effort = static_cast<size_t>(Quantity::kEffort);
  EXPECT_EQ(commanded.recordings[0].joints[0].signal[effort], logged.recordings[0].joints[0].signal[effort]);
  bool said = false;
  for (const std::string& warning : commanded.warnings) said = said || warning.find(command) != std::string::npos;
  EXPECT_TRUE(said);
}

}  // namespace
}  // namespace hrp::diagnosis
