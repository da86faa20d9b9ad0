// SPDX-License-Identifier: BSD-3-Clause
// Which laws a report lists as ones that the recordings cannot tell apart.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "diagnosis/evidence/indistinguishable.h"
#include "diagnosis/evidence/torque/findings.h"
#include "diagnosis/evidence/torque/misleading.h"
#include "diagnosis/simulation/bodies.h"
#include "tests/unit/diagnosis/torque_verdicts.h"

namespace hrp::diagnosis {
namespace {

// Adds dry friction to the efforts of the shoulder: a share of the load in the training recordings, in the others that
// or a constant level of the same mean size.
Experiment make_friction(const std::string& name, bool constant_in_held_out) {
  Experiment e = make_simulated_experiment(name, kArm, {"shoulder", "elbow"}, {});
  constexpr double kRatio = 0.3;
  for (Recording& r : e.recordings) {
    JointColumns& joint = r.joints[0];
    double mean = 0.0;
    for (double effort : joint.signal[2]) mean += std::abs(effort) / static_cast<double>(r.size());
    const bool constant = constant_in_held_out && !r.spec.train;
    for (size_t k = 0; k < r.size(); ++k)
      joint.signal[2][k] +=
          kRatio * (constant ? mean : std::abs(joint.signal[2][k])) * std::tanh(joint.signal[1][k] / 0.02);
  }
  return e;
}

// The finding of dry friction at the shoulder, and whether it lists a constant level.
bool lists_constant_level(const Experiment& e) {
  for (const Finding& f : judge_torque(e, 1).evidence.findings) {
    if (f.effect != get_effect(EffectId::kLoadFriction).name || f.where.begin().value() != "shoulder") continue;
    EXPECT_EQ(f.grade, Grade::kSupported) << f.statement;
    const std::string constant = get_effect(EffectId::kCoulomb).name;
    return std::any_of(f.alternatives.begin(), f.alternatives.end(),
                       [&](const auto& a) { return a.effect == constant; });
  }
  ADD_FAILURE() << "no friction of the load";
  return false;
}

// Odds in the training recordings alone decided before. A real arm was told friction of the load without a word of the
// constant level that predicts its held-out recording better.
TEST(TorqueRivals, DryFrictionThatPredictsHeldOutRecordingsBetterIsListed) {
  EXPECT_TRUE(lists_constant_level(make_friction("rivals_constant", true)));
  EXPECT_FALSE(lists_constant_level(make_friction("rivals_load", false)));
}

// Drives that give three quarters of what they log, behind friction that takes most of the effort: what is missing of
// the weight looks like a force that lifts a link, or like a light link.
TEST(TorqueRivals, GainsOfTheDrivesAreListedBesideAForceThatCarriesTheirWeight) {
  Hypothesis hidden{{EffectId::kViscous, kShoulder, {12.0}},
                    {EffectId::kCoulomb, kShoulder, {8.0, 0.0, 5e-4}},
                    {EffectId::kViscous, kElbow, {6.0}},
                    {EffectId::kCoulomb, kElbow, {4.0, 0.0, 5e-4}}};
  Experiment e = simulate_arm("rivals_gains", hidden);
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) {
    for (JointColumns& joint : r.joints) {
      for (double& y : joint.signal[2]) y *= 0.75;
    }
  }
  const std::string gain = get_effect(EffectId::kTorqueConstant).name;
  bool any = false;
  for (const Finding& f : judge_torque(e, 1).evidence.findings) {
    any = any || f.effect == gain;
    if (!f.where.contains("link")) continue;
    EXPECT_NE(f.grade, Grade::kSupported) << f.statement;
    any = any ||
          std::any_of(f.alternatives.begin(), f.alternatives.end(), [&](const auto& a) { return a.effect == gain; });
  }
  EXPECT_TRUE(any);
}

// The elbow of an arm moved at 0.5 to 0.9 rad/s: its friction at rest was listed as 1e121 N m.
TEST(TorqueRivals, StribeckFrictionHasNoValuesWhereTheMotionIsTooFastToTellTheFrictionAtRest) {
  const Experiment e = simulate_arm("rivals_fast", make_arm_drives());
  const TorqueData data = make_torque_data(e);
  GradedTerm level;
  level.term = {&find_term_row(&TermRow::level), kElbow};
  level.parameters = level.width = Eigen::VectorXd::Constant(1, 1.0);
  const auto count_values = [&](const Range& rest) {
    level.curve = {true, {0.03, 0.01, 0.1}, {1.0, 0.9, 1.1}, rest, 0.0};
    for (const Alternative& a : list_indistinguishable(data, level, nullptr, nullptr)) {
      if (a.effect == get_effect(EffectId::kStribeck).name) return static_cast<int>(a.parameters.size());
    }
    return -1;
  };
  EXPECT_EQ(count_values({1.5, 1.2, 1.8}), 3);
  EXPECT_EQ(count_values({50.0, -2000.0, 2100.0}), 0);
}

// The place of a mass is a link, and there is no joint of the last one's number: it was read behind the end of the
// list.
TEST(TorqueRivals, AMassAtTheLastLinkIsNoPlayOfAJoint) {
  Experiment e;
  e.robot.tree.links.resize(2);
  TorqueData data;
  data.experiment = &e;
  GradedTerm mass;
  mass.term = {&find_term_row(&TermRow::load), 1};
  mass.parameters = mass.width = Eigen::VectorXd::Constant(4, 0.01);
  EXPECT_TRUE(list_indistinguishable(data, mass, nullptr, nullptr).empty());
}

// kArm, hanging down.
std::string make_hanging_arm() {
  std::string arm = kArm;
  const std::string joint = "<parent link=\"base\"/><child link=\"upper\"/>";
  return arm.replace(arm.find(joint), joint.size(), joint + "<origin rpy=\"0 1.5708 0\"/>");
}

bool is_zero(const Finding& f) {
  return f.effect == get_effect(EffectId::kJointOffset).name || f.effect == "base_tilt";
}

// The arm swings by half a radian, with a texture in each gear. To each joint alone, the zero of the shoulder's encoder
// is a constant torque.
TEST(TorqueRivals, AZeroThatIsAConstantTorqueAtEachJointIsOneCause) {
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kJointOffset, kShoulder, {0.08}});
  Experiment e = make_simulated_experiment("rivals_zero", make_hanging_arm(), kArmJoints, hidden);
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) {
    for (JointColumns& columns : r.joints) {
      for (size_t k = 0; k < r.size(); ++k)
        columns.signal[2][k] += 0.3 * std::sin(9.0 * columns.signal[0][k] + 0.2 * r.time[k]);
    }
  }
  bool zero = false;
  for (const Finding& f : judge_torque(e, 1).evidence.findings) {
    EXPECT_NE(f.effect, "constant_torque") << f.statement;
    zero = zero || is_zero(f);
  }
  EXPECT_TRUE(zero);
}

// A pendulum that is held out level and swings by 0.8 rad: its weight pulls at it from the one side.
TEST(TorqueRivals, PlayUnderALoadOfOneSideIsListedAndNoSpringIsSupported) {
  constexpr double kGap = 0.05, kTurn = 0.8;  // [rad]
  Experiment e = make_simulated_experiment("rivals_play", kPendulum, {"hinge"}, {});
  e.scenario.drive = "effort";
  const Plant plant = make_plant(e, {});
  TestNoise noise;
  for (Recording& r : e.recordings) {
    const auto n = static_cast<long>(r.size());
    const double w = 2.0 + 0.7 * static_cast<double>(&r - e.recordings.data());
    Eigen::MatrixXd q(n, 1), v(n, 1), a(n, 1);
    for (long k = 0; k < n; ++k) {
      const double t = r.time[static_cast<size_t>(k)];
      q(k, 0) = kTurn * std::sin(w * t);
      v(k, 0) = kTurn * w * std::cos(w * t);
      a(k, 0) = -w * w * q(k, 0);
    }
    const Eigen::MatrixXd tau = calc_efforts(plant, q, v, a);
    for (long k = 0; k < n; ++k) {
      JointColumns& hinge = r.joints[0];
      const auto at = static_cast<size_t>(k);
      hinge.signal[0][at] = q(k, 0) + std::copysign(0.5 * kGap, tau(k, 0));
      hinge.signal[1][at] = v(k, 0);
      hinge.signal[2][at] = tau(k, 0) + 0.2 * std::tanh(v(k, 0) / 0.02) + 0.05 * v(k, 0) +
                            0.01 * std::sin(9.0 * q(k, 0)) + 0.003 * noise.draw();
    }
    forget_commands(&r);
  }
  std::optional<Alternative> play;
  for (const Finding& f : judge_torque(e, 1).evidence.findings) {
    const bool spring = f.effect == get_effect(EffectId::kSpring).name;
    EXPECT_FALSE(spring && f.grade == Grade::kSupported) << f.statement;
    for (const Alternative& a : f.alternatives) {
      if (a.effect == get_effect(EffectId::kBacklash).name) play = a;
    }
  }
  ASSERT_TRUE(play);
  EXPECT_NEAR(play->parameters[0].value[0], kGap,
              0.25 * kGap);  // a ripple of a hundredth of the weight moves it by a fifth
}

// The shoulder swings near its lowest point in training, and over the top in the held-out recording. Its zero is 0.1
// rad off.
Experiment make_swing() {
  Experiment e = make_simulated_experiment("rivals_upright", make_hanging_arm(), kArmJoints, {});
  e.scenario.drive = "effort";
  const Plant plant = make_plant(e, {});
  for (Recording& r : e.recordings) {
    const double amplitude = r.spec.train ? 0.4 : 2.6,
                 w = r.spec.train ? 2.5 + static_cast<double>(&r - e.recordings.data()) : 1.2;
    const auto n = static_cast<long>(r.size());
    Eigen::MatrixXd q = Eigen::MatrixXd::Zero(n, 2), v = q, a = q;
    for (long k = 0; k < n; ++k) {
      const double t = r.time[static_cast<size_t>(k)];
      q(k, 0) = amplitude * std::sin(w * t);
      v(k, 0) = amplitude * w * std::cos(w * t);
      a(k, 0) = -w * w * q(k, 0);
    }
    const Eigen::MatrixXd tau = calc_efforts(plant, q, v, a);
    for (long k = 0; k < n; ++k) {
      JointColumns& shoulder = r.joints[kShoulder];
      const auto at = static_cast<size_t>(k);
      shoulder.signal[0][at] = q(k, 0) + 0.1;
      shoulder.signal[1][at] = v(k, 0);
      shoulder.signal[2][at] =
          tau(k, 0) + 0.8 * std::tanh(v(k, 0) / 0.02) + 0.3 * std::sin(9.0 * q(k, 0) + 0.2 * r.time[at]);
      r.joints[kElbow].signal[0][at] = r.joints[kElbow].signal[1][at] = 0.0;
      r.joints[kElbow].signal[2][at] = tau(k, 1);
    }
  }
  return e;
}

// Near the lowest point, where it was trained, a displaced zero is a constant torque. Upright, it is the opposite one.
TEST(TorqueRivals, AConstantTorqueThatHeldOutMotionRefutesGivesWayToAZero) {
  const Experiment e = make_swing();
  const TorqueDesign design = make_torque_design(make_torque_data(e));
  Choice choice;
  choice.model.own.resize(design.joints.size());
  for (size_t t = 0; t < design.joints[0].terms.size(); ++t) {
    const TermRow& row = *design.joints[0].terms[t].row;
    if (row.level || row.is_constant()) choice.model.own[0].push_back(t);
  }
  ASSERT_EQ(choice.model.own[0].size(), 2u);
  choice.fit = fit_torque(design, choice.model);
  const double before = choice.fit.held[0];
  exchange_misleading_zeros(design, 1, &choice);
  EXPECT_EQ(choice.model.own[0].size(), 1u);
  ASSERT_EQ(choice.model.whole.size(), 1u);
  EXPECT_EQ(design.whole[choice.model.whole[0]].effect().family, EffectFamily::kZero);
  EXPECT_LT(choice.fit.held[0], 0.5 * before);
}

// Both turn the weight of the forearm about the elbow, by the same angle.
TEST(TorqueRivals, AZeroOfTheLastJointAndACentreOfMassBesideItsLineAreOneAnothersAlternative) {
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kComError, kFore, {0.0, 0.0, 0.03}});
  const TorqueVerdict verdict = judge_torque(make_simulated_experiment("rivals_turned", kArm, kArmJoints, hidden), 1);
  const Finding* f = find(verdict, "joint_offset", "elbow");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->grade, Grade::kAmbiguous) << f->statement;
  const auto centre = std::find_if(f->alternatives.begin(), f->alternatives.end(),
                                   [](const Alternative& a) { return a.effect == "com_error"; });
  ASSERT_NE(centre, f->alternatives.end()) << f->statement;
  EXPECT_NEAR(centre->parameters[0].value[2], 0.03, 0.002);  // the angle's second order, 0.2^2 / 2
}

}  // namespace
}  // namespace hrp::diagnosis
