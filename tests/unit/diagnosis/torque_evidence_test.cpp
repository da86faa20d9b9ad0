// SPDX-License-Identifier: BSD-3-Clause
// Torque space: friction and rotors of every joint come out with their sizes beside physics of no list; what the
// recordings cannot tell apart is listed; what is not there is not claimed.
#include <gmock/gmock.h>

#include <filesystem>

#include "diagnosis/evidence/polish.h"
#include "diagnosis/evidence/torque_findings.h"
#include "diagnosis/evidence/torque_gears.h"
#include "diagnosis/measurement/torque_residual.h"
#include "diagnosis/search/problem.h"
#include "diagnosis/simulation/bodies.h"
#include "diagnosis/simulation/windows.h"
#include "test_places.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

const std::vector<std::string> kJoints{"shoulder", "elbow"};

const Finding* find(const TorqueVerdict& verdict, const std::string& effect, const std::string& place) {
  for (const Finding& f : verdict.evidence.findings) {
    if (f.effect == effect && f.where.begin().value() == place) return &f;
  }
  return nullptr;
}

constexpr const char* kPendulum = R"(<robot name="pendulum"><link name="base"/>
    <link name="rod"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.03"/></inertial></link>
    <joint name="hinge" type="revolute"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/>
      <limit lower="-3" upper="3" effort="50" velocity="10"/></joint></robot>)";

// Texture of friction over position: in no list.
void add_texture(double amplitude, Experiment* e) {
  for (Recording& r : e->recordings) {
    for (JointColumns& joint : r.joints) {
      for (size_t k = 0; k < r.size(); ++k)
        joint.signal[2][k] += amplitude * std::sin(9.0 * joint.signal[0][k]) * std::tanh(joint.signal[1][k] / 0.05);
    }
  }
}

// Cutoff of the torque stage for an arm whose encoders have steps of 1.5 mrad, 4096 a turn [Hz].
double find_coarse_cutoff(const std::string& name, const Hypothesis& hidden) {
  Experiment e = make_simulated_experiment(name, kArm, kJoints, hidden);
  constexpr double kCount = 2.0 * M_PI / 4096.0;
  for (Recording& r : e.recordings) {
    for (JointColumns& joint : r.joints) {
      for (double& q : joint.signal[0]) q = kCount * std::round(q / kCount);
    }
  }
  return make_torque_data(e).cutoff;
}

// Noise of the accelerations must be small against what is missing, not only against the effort.
TEST(TorqueEvidence, LittleMissingTorqueBehindCoarseEncodersIsLookedForAtLowerFrequencies) {
  const double much = find_coarse_cutoff("coarse_much", {{EffectId::kViscous, kShoulder, {2.0}}, {EffectId::kCoulomb, kShoulder, {3.0, 0.0, 5e-4}},
                                                         {EffectId::kViscous, kElbow, {1.0}}, {EffectId::kCoulomb, kElbow, {2.0, 0.0, 5e-4}}});
  const double little = find_coarse_cutoff("coarse_little", {{EffectId::kViscous, kShoulder, {0.02}}, {EffectId::kViscous, kElbow, {0.01}}});
  EXPECT_LT(little, much);
}

Hypothesis make_drives() {
  return {{EffectId::kViscous, kShoulder, {0.8}}, {EffectId::kCoulomb, kShoulder, {1.5, 0.0, 5e-4}},
          {EffectId::kRotorInertia, kShoulder, {0.6}}, {EffectId::kViscous, kElbow, {0.4}},
          {EffectId::kCoulomb, kElbow, {0.8, 0.0, 5e-4}}, {EffectId::kRotorInertia, kElbow, {0.3}}};
}

void expect_drives(const TorqueVerdict& verdict, const Hypothesis& hidden) {
  for (const Effect& truth : hidden) {
    const Finding* f = find(verdict, get_effect(truth.id).name, kJoints[static_cast<size_t>(truth.place.index)]);
    ASSERT_NE(f, nullptr) << get_effect(truth.id).name << " at joint " << truth.place.index;
    EXPECT_EQ(f->grade, Grade::kSupported) << f->statement;
    // 15 %: texture of a tenth of the friction is in no term; it moves viscous friction, the smallest part, most.
    EXPECT_NEAR(f->parameters[0].value[0], truth.p[0], 0.15 * truth.p[0]) << f->statement;
  }
}

TEST(TorqueEvidence, FrictionAndRotorsOfEveryJointComeOutBesideTextureOfNoList) {
  const Hypothesis hidden = make_drives();
  Experiment e = make_simulated_experiment("torque_dirty", kArm, kJoints, hidden);
  add_texture(0.1, &e);
  const TorqueVerdict verdict = judge_torque(e, 1);
  ASSERT_TRUE(verdict.judged);
  EXPECT_EQ(verdict.with_drives, 2);
  expect_drives(verdict, hidden);
}

// Before, recordings below a second were left to a search of sets of few effects, which reported that no effect explains
// them.
TEST(TorqueEvidence, StepsOfLessThanASecondShowFrictionAndRotors) {
  Experiment e = make_simulated_experiment("torque_steps", kArm, kJoints, make_drives());
  constexpr long kFirst = 500, kSamples = 180;  // 0.9 s of 6 s, in motion
  for (Recording& r : e.recordings) {
    const auto cut = [](std::vector<double>* column) { *column = {column->begin() + kFirst, column->begin() + kFirst + kSamples}; };
    cut(&r.time);
    for (JointColumns& joint : r.joints) {
      for (std::vector<double>* column : {&joint.command, &joint.command_rate, &joint.signal[0], &joint.signal[1], &joint.signal[2]}) cut(column);
    }
  }
  const TorqueVerdict verdict = judge_torque(e, 1);
  ASSERT_TRUE(verdict.judged);
  EXPECT_GT(verdict.evidence.explained, 0.9);
  for (const std::string& joint : kJoints) EXPECT_NE(find(verdict, "rotor_inertia", joint), nullptr) << joint;
}

// Before, friction took its place: three times too large, and a rotor too small by a fifth.
TEST(TorqueEvidence, HysteresisIsNamedAndLeavesFrictionAndRotorTheirSizes) {
  Hypothesis hidden = make_drives();
  hidden.push_back({EffectId::kHysteresis, kShoulder, {60.0, 0.02}});
  const TorqueVerdict verdict = judge_torque(make_simulated_experiment("torque_hysteresis", kArm, kJoints, hidden), 1);
  const Finding* f = find(verdict, "hysteresis", "shoulder");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->grade, Grade::kSupported) << f->statement;
  // Yield angles are tried by factors of 1.5, and the filter rounds the element's corners.
  EXPECT_NEAR(f->parameters[0].value[0] * f->parameters[1].value[0], 1.2, 0.3) << f->statement;
  EXPECT_NEAR(f->parameters[1].value[0], 0.02, 0.01) << f->statement;
  EXPECT_EQ(find(verdict, "hysteresis", "elbow"), nullptr);
  for (const Effect& truth : make_drives()) {
    const Finding* drive = find(verdict, get_effect(truth.id).name, kJoints[static_cast<size_t>(truth.place.index)]);
    ASSERT_NE(drive, nullptr) << get_effect(truth.id).name;
    EXPECT_NEAR(drive->parameters[0].value[0], truth.p[0], 0.2 * truth.p[0]) << drive->statement;
  }
}

// Bristles bend by 3 mrad before they slip, six times what the tool assumes: all friction has that memory.
TEST(TorqueEvidence, PreSlidingOfDryFrictionIsNoHysteresis) {
  Hypothesis hidden = make_drives();
  for (Effect& effect : hidden) {
    if (effect.id == EffectId::kCoulomb) effect.p[2] = 3e-3;
  }
  const TorqueVerdict verdict = judge_torque(make_simulated_experiment("torque_presliding", kArm, kJoints, hidden), 1);
  for (const std::string& joint : kJoints) EXPECT_EQ(find(verdict, "hysteresis", joint), nullptr) << joint;
}

TEST(TorqueEvidence, NothingHiddenGivesNoFinding) {
  const Experiment e = make_simulated_experiment("torque_none", kArm, kJoints, {});
  const TorqueVerdict verdict = judge_torque(e, 1);
  EXPECT_TRUE(verdict.evidence.findings.empty()) << verdict.evidence.findings[0].statement;
}

TEST(TorqueEvidence, ALoadInTheHandIsNamedAtItsLinkWithItsMass) {
  Hypothesis hidden = make_drives();
  hidden.push_back({EffectId::kPayload, kFore, {0.8, 0.3, 0.0, 0.0, 0.0}});
  const Experiment e = make_simulated_experiment("torque_load", kArm, kJoints, hidden);
  const TorqueVerdict verdict = judge_torque(e, 1);
  ASSERT_FALSE(verdict.evidence.findings.empty());
  bool named = false;
  for (const Finding& f : verdict.evidence.findings) {
    if (f.family != get_family_name(EffectFamily::kMass)) continue;
    EXPECT_EQ(f.where.at("link"), "fore") << f.statement;
    named = true;
  }
  EXPECT_TRUE(named);
}

// A load far out on a light link: its moment of inertia about the link's frame grows with the square of its distance.
TEST(TorqueEvidence, ALoadFarFromTheLinksCentreOfMassHasItsMassAndPlace) {
  Hypothesis hidden = make_drives();
  constexpr double kMass = 0.8, kFar = 0.35;  // [kg]; [m], 0.15 the centre of mass
  hidden.push_back({EffectId::kPayload, kFore, {kMass, kFar, 0.0, 0.05, 0.0}});
  const Experiment e = make_simulated_experiment("torque_far_load", kArm, kJoints, hidden);
  const TorqueVerdict verdict = judge_torque(e, 1);
  const Finding* f = find(verdict, "payload", "fore");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->grade, Grade::kSupported) << f->statement;
  // 5 %: with its inertia taken at the link's centre of mass the wrong effects were named.
  EXPECT_NEAR(f->parameters[0].value[0], kMass, 0.05 * kMass) << f->statement;
  EXPECT_NEAR(f->parameters[1].value[0], kFar, 0.05 * kFar) << f->statement;
}

// A tool that is not on the robot any more. With a tenth of the friction in no list a force was named in its place.
TEST(TorqueEvidence, ALinkOfTwoFifthsOfItsMassHasAWrongMassAndNoForceOnIt) {
  Hypothesis hidden = make_drives();
  hidden.push_back({EffectId::kMassError, kFore, {0.4}});
  Experiment e = make_simulated_experiment("torque_light", kArm, kJoints, hidden);
  add_texture(0.2, &e);
  const TorqueVerdict verdict = judge_torque(e, 1);
  const Finding* f = find(verdict, "mass_error", "fore");
  ASSERT_NE(f, nullptr);
  EXPECT_NEAR(f->parameters[0].value[0], 0.4, 0.02);  // a thirtieth of what is missing; texture belongs to friction
  EXPECT_EQ(find(verdict, "external_force", "fore"), nullptr);
}

// A load that nobody stated makes every drive before it look weak: alone it does what all their gains do together.
TEST(TorqueEvidence, GainsOfAnArmThatCarriesALoadHaveTheLoadAsTheirAlternative) {
  std::string light = kArm;  // all that both drives carry is the forearm
  const std::string upper = "<mass value=\"2\"/>";
  light.replace(light.find(upper), upper.size(), "<mass value=\"0.2\"/>");
  Hypothesis hidden = make_drives();
  hidden.push_back({EffectId::kPayload, kFore, {0.2, 0.15, 0.0, 0.0, 0.0}});
  Experiment e = make_simulated_experiment("torque_gain_or_load", light, kJoints, hidden);
  add_texture(0.1, &e);
  const TorqueDesign design = make_torque_design(make_torque_data(e));
  Choice choice = choose_torque_model(design, 1);
  choice.model = {list_usual_terms(design), {}};
  for (size_t i = 0; i < design.joints.size(); ++i) {
    for (size_t t = 0; t < design.joints[i].terms.size(); ++t) {
      if (design.joints[i].terms[t].row->scales_effort) choice.model.own[i].push_back(t);
    }
    std::sort(choice.model.own[i].begin(), choice.model.own[i].end());
  }
  choice.fit = fit_torque(design, choice.model);
  for (const GradedTerm& g : grade_terms(design, choice, 1)) {
    if (!g.term.row->scales_effort) continue;
    const bool listed = std::any_of(g.rivals.begin(), g.rivals.end(), [](const Rival& r) { return r.term.row->is_of_mass(); });
    EXPECT_TRUE(listed) << "gain of " << kJoints[static_cast<size_t>(g.term.place)];
  }
}

// The first `seconds` of a recording.
Recording take(const Recording& whole, double seconds) {
  Recording r = whole;
  const auto rows = static_cast<size_t>(std::count_if(r.time.begin(), r.time.end(), [&](double t) { return t - r.time[0] < seconds; }));
  r.time.resize(rows);
  for (JointColumns& joint : r.joints) {
    for (std::vector<double>* column : {&joint.command, &joint.command_rate, &joint.signal[0], &joint.signal[1], &joint.signal[2]})
      column->resize(std::min(column->size(), rows));
  }
  return r;
}

// Five stretches of two seconds in all, one of which has all that the elbow tells: its own parts are one more.
TEST(TorqueEvidence, FrictionOfAJointThatMovesInOneShortRecordingIsFound) {
  Experiment e = make_simulated_experiment("torque_short", kArm, kJoints, make_drives());
  const Recording all = e.recordings[0];
  e.recordings = {take(all, 5.2), take(all, 5.2), take(all, 2.4)};
  for (size_t r : {0u, 1u}) {
    JointColumns& elbow = e.recordings[r].joints[kElbow];
    std::fill(elbow.signal[0].begin(), elbow.signal[0].end(), elbow.signal[0][0]);
    std::fill(elbow.signal[1].begin(), elbow.signal[1].end(), 0.0);
  }
  const TorqueVerdict verdict = judge_torque(e, 1);
  EXPECT_TRUE(find(verdict, "coulomb_friction", "elbow") || find(verdict, "viscous_friction", "elbow"));
}

// A second without samples is no straight motion: friction is that of the whole recording.
TEST(TorqueEvidence, AGapInALogTellsNothingAndChangesNoFriction) {
  const Hypothesis hidden = make_drives();
  Experiment e = make_simulated_experiment("torque_gap", kArm, kJoints, hidden);
  for (Recording& r : e.recordings) {
    const auto drop = [&](std::vector<double>* column) {
      if (column->size() == 1200) column->erase(column->begin() + 400, column->begin() + 600);
    };
    drop(&r.time);
    for (JointColumns& joint : r.joints) {
      for (std::vector<double>* column : {&joint.command, &joint.command_rate, &joint.signal[0], &joint.signal[1], &joint.signal[2]}) drop(column);
    }
    ASSERT_EQ(r.time.size(), 1000u);
  }
  expect_drives(judge_torque(e, 1), hidden);
}

// An effort that swings between its limits jumps by more within a sample than friction is: it tells nothing beside a
// calm stretch.
TEST(TorqueEvidence, AServoThatSwingsBetweenItsLimitsChangesNoFriction) {
  const Hypothesis hidden = make_drives();
  Experiment e = make_simulated_experiment("torque_limits", kArm, kJoints, hidden);
  for (size_t k = 300; k < 900; ++k) e.recordings[0].joints[kElbow].signal[2][k] = k / 3 % 2 ? 50.0 : -50.0;
  expect_drives(judge_torque(e, 1), hidden);
}

// One link alone: a mass that is wrong by a factor and a gain of the drive say the same in every motion.
TEST(TorqueEvidence, GainAndMassOfASingleLinkAreAmbiguousWithEachOther) {
  const Experiment e = make_simulated_experiment("torque_gain", kPendulum, {"hinge"}, {{EffectId::kTorqueConstant, 0, {0.8}}});
  const TorqueVerdict verdict = judge_torque(e, 1);
  ASSERT_EQ(verdict.evidence.findings.size(), 1u);
  const Finding& f = verdict.evidence.findings[0];
  EXPECT_EQ(f.grade, Grade::kAmbiguous) << f.statement;
  std::vector<std::string> all{f.effect};
  for (const Alternative& a : f.alternatives) all.push_back(a.effect);
  EXPECT_THAT(all, testing::IsSupersetOf({"torque_constant_error", "mass_error"}));
}

// Lowering a load takes less torque than its weight, lifting it does not: by the mean of both the arm looks too heavy.
TEST(TorqueEvidence, AGearThatTheLoadHardlyTurnsIsNamedWithItsLossAndIsNoWrongMass) {
  Hypothesis hidden;
  for (int joint : {kShoulder, kElbow}) {
    hidden.push_back({EffectId::kViscous, joint, {0.1}});
    hidden.push_back({EffectId::kCoulomb, joint, {0.1, 0.0, 5e-4}});
    hidden.push_back({EffectId::kRotorInertia, joint, {0.01}});
  }
  hidden.push_back({find_effect("backdriving_friction")->id, kElbow, {0.6, 5e-4}});
  const TorqueVerdict verdict = judge_torque(make_simulated_experiment("torque_gear", kArm, kJoints, hidden), 1);
  const Finding* f = find(verdict, "backdriving_friction", "elbow");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->grade, Grade::kSupported) << f->statement;
  EXPECT_EQ(find(verdict, "backdriving_friction", "shoulder"), nullptr);
  // Friction of 3/7 of the load both ways beside a torque constant 10/7 times the stated one is the same torque.
  ASSERT_FALSE(f->alternatives.empty());
  EXPECT_EQ(f->alternatives[0].effect, "load_dependent_friction");
  EXPECT_NEAR(f->alternatives[0].parameters[0].value[0], 3.0 / 7.0, 0.06);  // as far as the ratio's tenth moves it
  // A tenth: where the load changes sides the smoothed torque is that of neither.
  EXPECT_NEAR(f->parameters[0].value[0], 0.6, 0.06) << f->statement;
  for (const Finding& other : verdict.evidence.findings) {
    EXPECT_NE(other.family, get_family_name(EffectFamily::kMass)) << other.statement;
    EXPECT_NE(other.family, get_family_name(EffectFamily::kGain)) << other.statement;
  }
}

GradedTerm make_graded(bool TermRow::*property, int place, double value, double width) {
  GradedTerm g;
  g.term = {&find_term_row(property), place};
  g.parameters = Eigen::VectorXd::Constant(1, value), g.std = g.width = Eigen::VectorXd::Constant(1, width);
  g.named = true, g.grade = Grade::kSupported;
  return g;
}

// A wrong mass with load-dependent friction and a gear that the load hardly turns take the same torque both ways.
TEST(TorqueEvidence, AWrongMassBesideFrictionOfTheLoadIsAGearThatLosesBackwards) {
  GradedTerm mass = make_graded(&TermRow::factor, 1, -0.46, 0.1), friction = make_graded(&TermRow::by_load, 0, 0.37, 0.1);
  const double s = 0.54, mu = 0.37, r = calc_backward_loss(mu);
  double k = calc_gear_gain(mass, friction);
  EXPECT_NEAR(s * (1.0 + mu), 1.0 / k, 1e-12);        // lifted
  EXPECT_NEAR(s * (1.0 - mu), (1.0 - r) / k, 1e-12);  // lowered
  friction.term.shape = kLoadOfDrive;
  k = calc_gear_gain(mass, friction);
  EXPECT_NEAR(s / (1.0 - mu), 1.0 / k, 1e-12);
  EXPECT_NEAR(s / (1.0 + mu), (1.0 - r) / k, 1e-12);
}

// Half of a link's mass is not forgotten, a gear that the load hardly turns is common: the rows are the same.
TEST(TorqueEvidence, HalfOfAMassBesideFrictionOfTheLoadIsReportedAsAGearThatLosesBackwards) {
  const TorqueDesign design = make_torque_design(make_torque_data(make_simulated_experiment("torque_gears", kPendulum, {"hinge"}, {})));
  // By the nominal load: lifting takes 0.54 + 0.37 of it, lowering 0.54 - 0.37.
  std::vector<GradedTerm> graded{make_graded(&TermRow::factor, 1, -0.46, 0.02), make_graded(&TermRow::by_load, 0, 0.37, 0.02)};
  explain_by_gears(design, &graded);
  EXPECT_EQ(graded[1].term.effect().name, "backdriving_friction");
  EXPECT_NEAR(graded[1].parameters[0], 1.0 - 0.17 / 0.91, 1e-12);
  EXPECT_EQ(graded[0].term.effect().name, "torque_constant_error");
  EXPECT_NEAR(1.0 - graded[0].parameters[0], 1.0 / 0.91, 1e-12);
  EXPECT_EQ(graded[0].grade, Grade::kAmbiguous);
}

TEST(TorqueEvidence, AMassThatIsATenthOffStaysAMassAndItsFrictionCountsTheTrueLoad) {
  const TorqueDesign design = make_torque_design(make_torque_data(make_simulated_experiment("torque_gears", kPendulum, {"hinge"}, {})));
  std::vector<GradedTerm> graded{make_graded(&TermRow::factor, 1, 0.1, 0.02), make_graded(&TermRow::by_load, 0, 0.11, 0.02)};
  explain_by_gears(design, &graded);
  EXPECT_EQ(graded[0].term.effect().name, "mass_error");
  EXPECT_NEAR(graded[1].parameters[0], 0.1, 1e-12);
}

// One link of nominal mass behind such a gear: slow motion cannot tell, but masses are weighed.
TEST(TorqueEvidence, OfARealServoLossesOfTheGearAreNamedAndNoWrongMass) {
  const std::filesystem::path path = std::filesystem::path(HRP_SOURCE_DIR) / "../shared/recordings/bam_xl330_kp100/experiment.yaml";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  const TorqueVerdict verdict = judge_torque(load_experiment(path.string()), 1);
  EXPECT_EQ(find(verdict, "mass_error", "arm"), nullptr);
  EXPECT_NE(find(verdict, "load_dependent_friction", "servo"), nullptr);
}

// Level joints see a tilt of the base; the model of what was found is simulated with the gravity that the base sees.
TEST(TorqueEvidence, ATiltedBaseIsNamedAndItsModelHangsAlongTheTiltedGravity) {
  const EffectId tilt = find_effect("base_tilt")->id;
  const Hypothesis hidden{{tilt, 0, {0.0, 0.06}}};
  const Experiment e = make_simulated_experiment("torque_tilt", kArm, kJoints, hidden);
  const Plant plant = make_plant(e, hidden);
  EXPECT_NEAR(plant.model->gravity_W().x(), 9.81 * std::sin(0.06), 1e-9);
  EXPECT_NEAR(plant.model->gravity_W().z(), -9.81 * std::cos(0.06), 1e-9);
  const TorqueVerdict verdict = judge_torque(e, 1);
  std::vector<std::string> zeros;  // a level first axis cannot tell its own zero from the base's
  for (const Finding& f : verdict.evidence.findings) {
    if (f.family != get_family_name(EffectFamily::kZero)) continue;
    zeros.push_back(f.effect);
    for (const Alternative& a : f.alternatives) zeros.push_back(a.effect);
  }
  EXPECT_THAT(zeros, testing::Contains("base_tilt"));
}

// Friction of 0.8 N m (1 +- 0.3): moving and at rest the same as 0.8 N m beside a constant torque of 0.24 N m.
TEST(TorqueEvidence, AConstantTorqueIsAmongOthersFrictionThatHoldsMoreInOneDirection) {
  Hypothesis hidden = make_drives();
  hidden[4].p[1] = 0.3;
  const TorqueVerdict verdict = judge_torque(make_simulated_experiment("torque_one_sided", kArm, kJoints, hidden), 1);
  const Finding* constant = find(verdict, "constant_torque", "elbow");
  ASSERT_NE(constant, nullptr);
  const std::string friction = get_effect(EffectId::kCoulomb).name;
  const auto& list = constant->alternatives;
  const auto other = std::find_if(list.begin(), list.end(), [&](const Alternative& a) { return a.effect == friction; });
  ASSERT_NE(other, list.end()) << constant->statement;
  const Estimate& asymmetry = other->parameters[1];
  EXPECT_NEAR(asymmetry.value[0], 0.3, 1.96 * asymmetry.std[0]) << constant->statement;
  EXPECT_LT(asymmetry.std[0], 0.1);
}

// Springs that carry a part of an arm, and efforts of a log that leaves all of gravity out.
TEST(TorqueEvidence, WhatCarriesTheLinksBesideTheDrivesIsNamedWithItsShare) {
  for (const double share : {0.6, 1.0}) {
    Hypothesis hidden = make_drives();
    hidden.push_back({find_effect("gravity_compensation")->id, 0, {share}});
    const TorqueVerdict verdict = judge_torque(make_simulated_experiment("torque_carried", kArm, kJoints, hidden), 1);
    const Finding* carried = find(verdict, "gravity_compensation", "base");
    ASSERT_NE(carried, nullptr) << share;
    EXPECT_EQ(carried->grade, Grade::kSupported) << carried->statement;
    EXPECT_NEAR(carried->parameters[0].value[0], share, 0.02);  // three deviations of the spread between recordings
    EXPECT_EQ(find(verdict, "base_tilt", "base"), nullptr);
    for (const char* link : {"upper", "fore"}) EXPECT_EQ(find(verdict, "external_force", link), nullptr);
  }
}

// Real efforts as a controller would log them that compensates gravity elsewhere. The single pendulum hangs still at first
// and swings in the held-out part: what swings is no outlier.
TEST(TorqueEvidence, OfRealPendulumsWhoseLogsLeaveGravityOutGravityIsNamed) {
  for (const char* name : {"dfki_simple_pendulum", "dfki_double_pendulum"}) {
    const std::filesystem::path path = std::filesystem::path(HRP_SOURCE_DIR) / "../shared/recordings" / name / "experiment.yaml";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
    Experiment e = load_experiment(path.string());
    const Plant plant = make_plant(e, {});
    for (Recording& r : e.recordings) {
      Eigen::MatrixXd q(static_cast<long>(r.time.size()), e.num_joints());
      for (long j = 0; j < q.cols(); ++j) q.col(j) = Eigen::Map<const Eigen::VectorXd>(r.joints[static_cast<size_t>(j)].signal[0].data(), q.rows());
      const Eigen::MatrixXd rest = Eigen::MatrixXd::Zero(q.rows(), q.cols()), gravity = calc_efforts(plant, q, rest, rest);
      for (long j = 0; j < q.cols(); ++j) {
        for (long k = 0; k < q.rows(); ++k) r.joints[static_cast<size_t>(j)].signal[2][static_cast<size_t>(k)] -= gravity(k, j);
      }
    }
    const TorqueVerdict verdict = judge_torque(e, 1);
    const Finding* carried = find(verdict, "gravity_compensation", "base_link");
    ASSERT_NE(carried, nullptr) << name;
    // The torque constant of the single pendulum's drive is off by 11 %, by the notes beside its recordings 10 to 25 %.
    EXPECT_NEAR(carried->parameters[0].value[0], 1.0, 0.2) << carried->statement;
  }
}

// What a joint's rotor is beside a wrong mass is another number than alone: it must still be one.
TEST(TorqueEvidence, OfARealArmWithOneRecordingNoRotorWeighsLessThanNothing) {
  const std::filesystem::path path = std::filesystem::path(HRP_SOURCE_DIR) / "../shared/recordings/dfki_double_pendulum/experiment.yaml";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  Experiment e = load_experiment(path.string());
  e.recordings.resize(1);
  for (const Finding& f : judge_torque(e, 1).evidence.findings) {
    if (f.effect != "rotor_inertia") continue;
    EXPECT_GT(f.parameters[0].value[0], 0.0) << f.statement;
  }
}

TEST(TorqueEvidence, LateCommandsShowInTheServosOwnLawBesideFriction) {
  Hypothesis hidden = make_drives();
  hidden.push_back({EffectId::kDelay, kElbow, {0.012}});
  const TorqueVerdict verdict = judge_torque(make_simulated_experiment("torque_late", kArm, kJoints, hidden), 1);
  const Finding* f = find(verdict, "command_delay", "elbow");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(find(verdict, "command_delay", "shoulder"), nullptr);
  // A millisecond: a fifth of the recording's sample time, which the parabola through the scan resolves.
  EXPECT_NEAR(f->parameters[0].value[0], 0.012, 1e-3);
}

// Back-EMF of a motor at a voltage brakes as viscous friction kt^2/R does. Where supply, resistance and torque constant are
// stated it is in the model, and no finding: only what the gear adds is.
TEST(TorqueEvidence, BackEmfOfAStatedVoltageDriveIsNoFinding) {
  constexpr double kConstant = 2.0, kResistance = 5.0, kGear = 0.3;  // [N m/A], [ohm], [N m s/rad]
  Hypothesis hidden = make_drives();
  hidden[3].p[0] = kConstant * kConstant / kResistance + kGear;  // at the elbow
  Experiment e = make_simulated_experiment("torque_voltage", kArm, kJoints, hidden);
  const Scenario stated = parse_scenario(
      "robot: robot.urdf\nbase: fixed\ndrive: voltage\nservo: {joints: {elbow: {kp: 500, kd: 25, supply: 125, "
      "resistance: 5, torque_constant: 2}}}\n", "voltage.yaml");
  ASSERT_EQ(stated.drive, "servo");
  EXPECT_DOUBLE_EQ(stated.servo_joints.at("elbow").kp, 200.0);  // what the recordings were made with
  EXPECT_DOUBLE_EQ(stated.servo_joints.at("elbow").effort_limit, 50.0);
  e.scenario.servo_joints = stated.servo_joints, e.scenario.joint_laws = stated.joint_laws;
  const TorqueVerdict verdict = judge_torque(e, 1);
  const Finding* f = find(verdict, "viscous_friction", "elbow");
  ASSERT_NE(f, nullptr);
  EXPECT_NEAR(f->parameters[0].value[0], kGear, 0.15 * kGear) << f->statement;  // as for all drives here
}

// A servo works with a velocity whether or not somebody recorded it.
TEST(TorqueEvidence, ABiasOfALogShowsInTheServosLawWithoutRecordedVelocities) {
  Experiment e = make_simulated_experiment("torque_bias", kArm, kJoints, make_drives());
  for (Recording& r : e.recordings) {
    for (double& effort : r.joints[kElbow].signal[2]) effort += 0.7;
    for (JointColumns& joint : r.joints) joint.signal[1].clear();
  }
  const TorqueVerdict verdict = judge_torque(e, 1);
  const Finding* f = find(verdict, "sensor_bias", "/joint_states/elbow/effort");
  ASSERT_NE(f, nullptr);
  EXPECT_NEAR(f->parameters[0].value[0], 0.7, 0.02);  // three times what 0.02 N m of noise and a smoothed rate leave
  EXPECT_EQ(find(verdict, "constant_torque", "elbow"), nullptr);
}

// What a drive does late hardly shows in its missing torque; its simulated motion tells it.
TEST(TorqueEvidence, ALagBesideFrictionIsFoundThroughTheJointsSimulation) {
  Hypothesis hidden = make_drives();
  hidden.push_back({EffectId::kLag, kElbow, {0.02}});
  const Experiment e = make_simulated_experiment("torque_lag", kArm, kJoints, hidden);
  const Hypothesis found = polish_joints(make_problem(e, 1), make_drives(), nullptr, true);
  const auto lag = std::find_if(found.begin(), found.end(), [](const Effect& x) { return x.id == EffectId::kLag || x.id == EffectId::kDelay; });
  ASSERT_NE(lag, found.end());
  EXPECT_EQ(lag->place, at_joint(kElbow));
  EXPECT_NEAR(lag->p[0], 0.02, 0.004);  // a delay of as many milliseconds does nearly the same below 5 Hz
}

// Without them no servo's law tells the effort of a log.
void forget_commands(Recording* r) {
  for (JointColumns& joint : r->joints) joint.command.clear(), joint.command_rate.clear();
}

// A bus or a filter brings efforts late: in fast motions that looks like friction, and hides the rotors.
TEST(TorqueEvidence, EffortsThatAreLoggedLateAreNoFriction) {
  const Hypothesis hidden = make_drives();
  Experiment e = make_simulated_experiment("torque_late_log", kArm, kJoints, hidden);
  constexpr size_t kLate = 4;  // samples of 5 ms
  for (Recording& r : e.recordings) {
    for (JointColumns& joint : r.joints) {
      std::vector<double>& effort = joint.signal[2];
      std::rotate(effort.rbegin(), effort.rbegin() + kLate, effort.rend());
      std::fill(effort.begin(), effort.begin() + kLate, effort[kLate]);
    }
    forget_commands(&r);
  }
  const TorqueVerdict verdict = judge_torque(e, 1);
  expect_drives(verdict, hidden);
  for (const std::string& joint : kJoints) {
    const Finding* f = find(verdict, "sensor_delay", "/joint_states/" + joint + "/effort");
    ASSERT_NE(f, nullptr) << joint;
    // Slow friction hardly changes in 20 ms: the interval says how little the elbow tells, and is a third of its delay.
    EXPECT_NEAR(f->parameters[0].value[0], 0.02, 2.0 * f->parameters[0].std[0]) << f->statement;
    EXPECT_LT(f->parameters[0].std[0], 0.007) << f->statement;
  }
}

void add_spring(double stiffness, Recording* r) {
  JointColumns& elbow = r->joints[kElbow];
  for (size_t k = 0; k < r->size(); ++k) elbow.signal[2][k] += stiffness * elbow.signal[0][k];
  forget_commands(r);
}

// Held-out recordings together are predicted better with the spring, the last one worse: it is no property of the joint.
TEST(TorqueEvidence, ASpringThatOneHeldOutRecordingDeniesIsNotSupported) {
  Experiment e = make_simulated_experiment("torque_denied", kArm, kJoints, make_drives());
  e.recordings.push_back(e.recordings[2]);
  add_spring(5.0, &e.recordings[0]), add_spring(5.0, &e.recordings[1]);
  Experiment agreed = e;
  add_spring(8.0, &e.recordings[2]), add_spring(-1.0, &e.recordings[3]);
  add_spring(5.0, &agreed.recordings[2]), add_spring(5.0, &agreed.recordings[3]);
  const TorqueVerdict denied = judge_torque(e, 1), confirmed = judge_torque(agreed, 1);
  const Finding* f = find(denied, "parallel_spring", "elbow");
  if (f != nullptr) {
    EXPECT_EQ(f->grade, Grade::kAmbiguous) << f->statement;
  }
  const Finding* true_one = find(confirmed, "parallel_spring", "elbow");
  ASSERT_NE(true_one, nullptr);
  EXPECT_EQ(true_one->grade, Grade::kSupported) << true_one->statement;
}

// What not every drive has needs a recording that it was not fitted to.
TEST(TorqueEvidence, WithoutAHeldOutRecordingALoadIsAmbiguousAndFrictionIsSupported) {
  Hypothesis hidden = make_drives();
  hidden.push_back({EffectId::kPayload, kFore, {0.8, 0.3, 0.0, 0.0, 0.0}});
  Experiment e = make_simulated_experiment("torque_single", kArm, kJoints, hidden);
  add_texture(0.1, &e);
  for (Recording& r : e.recordings) r.spec.train = true;
  const TorqueVerdict verdict = judge_torque(e, 1);
  const Finding* load = find(verdict, "payload", "fore");
  ASSERT_NE(load, nullptr);
  EXPECT_EQ(load->grade, Grade::kAmbiguous) << load->statement;
  const Finding* dry = find(verdict, "coulomb_friction", "shoulder");
  ASSERT_NE(dry, nullptr);
  EXPECT_EQ(dry->grade, Grade::kSupported) << dry->statement;
}

// Without efforts a delay T looks much like viscous friction kp T and a rotor kd T. What differs shows where the drive
// turns around, unless the joint sticks there: such stretches are left out.
TEST(TorqueEvidence, LateCommandsOfPositionLogsAreNoViscousFrictionAndNoRotor) {
  Hypothesis hidden{{EffectId::kCoulomb, kShoulder, {1.5, 0.0, 5e-4}}, {EffectId::kCoulomb, kElbow, {0.8, 0.0, 5e-4}}};
  for (int joint : {kShoulder, kElbow}) hidden.push_back({EffectId::kDelay, joint, {0.012}});
  Experiment e = make_simulated_experiment("torque_bus", kArm, kJoints, hidden);
  for (Recording& r : e.recordings) {
    for (JointColumns& joint : r.joints) joint.signal[2].clear();
  }
  const TorqueVerdict verdict = judge_torque(e, 1);
  for (const std::string& joint : kJoints) {
    const Finding* f = find(verdict, "command_delay", joint);
    ASSERT_NE(f, nullptr) << joint;
    EXPECT_NEAR(f->parameters[0].value[0], 0.012, 1e-3) << f->statement;  // a fifth of the sample time
    EXPECT_EQ(find(verdict, "viscous_friction", joint), nullptr);
    EXPECT_EQ(find(verdict, "rotor_inertia", joint), nullptr);
  }
}

// A quadruped hangs and swings its legs; a delay of all its commands is 8 ms +- 10 ms, in the place of twelve rotors.
// Its authors have a rotor in each joint. What the recordings do not tell from none takes the place of nothing.
void expect_rotors_of_the_quadruped(bool exchanged) {
  const std::filesystem::path path = std::filesystem::path(HRP_SOURCE_DIR) / "../shared/recordings/go2_hanging/experiment.yaml";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  Experiment e = load_experiment(path.string());
  for (Recording& r : e.recordings) r.spec.train = r.spec.train != exchanged;
  const TorqueVerdict verdict = judge_torque(e, 1);
  int rotors = 0;
  for (const Finding& f : verdict.evidence.findings) rotors += f.effect == "rotor_inertia" ? 1 : 0;
  EXPECT_GE(rotors, 7);  // more than half of twelve; with the delay in their place three
  for (const char* leg : {"FL", "FR", "RR"}) {
    const Finding* f = find(verdict, "rotor_inertia", leg + std::string("_calf_joint"));
    ASSERT_NE(f, nullptr) << leg;
    // 0.042 by the authors, 0.041 to 0.045 by least squares; friction and the delay move it by a fifth.
    EXPECT_NEAR(f->parameters[0].value[0], 0.042, 0.2 * 0.042) << f->statement;
  }
  for (const Finding& f : verdict.evidence.findings)
    EXPECT_FALSE(f.effect == "command_delay" && f.grade == Grade::kSupported) << f.statement;
}

TEST(TorqueEvidence, ADelayThatIsNotToldFromNoneLeavesTheRotorsOfARealRobot) { expect_rotors_of_the_quadruped(false); }

// Learnt from the other recording, the delay is 12 ms +- 1 ms. It leaves a twelfth less than friction and rotors do.
TEST(TorqueEvidence, ADelayThatPredictsHardlyBetterThanRotorsTakesNotTheirPlace) { expect_rotors_of_the_quadruped(true); }

const char* const kCart = R"(<robot name="cart"><link name="base"/>
    <link name="cart"><inertial><mass value="5"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.03"/></inertial></link>
    <joint name="slide" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/>
      <limit lower="-3" upper="3" effort="500" velocity="10"/></joint></robot>)";

TEST(TorqueEvidence, FrictionOfASlideHasUnitsOfForces) {
  const Experiment e = make_simulated_experiment("torque_slide", kCart, {"slide"}, {{EffectId::kViscous, 0, {8.0}}});
  const TorqueVerdict verdict = judge_torque(e, 1);
  const Finding* f = find(verdict, "viscous_friction", "slide");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->parameters[0].unit, "N s/m");
  EXPECT_EQ(verdict.evidence.remaining[0].unit, "N");
}

// On a level slide the cart's mass, the rotor that drives it and the drive's gain are one number.
TEST(TorqueEvidence, InertiaOfALevelCartIsAmbiguousWhateverItIsCalled) {
  const Experiment e = make_simulated_experiment("torque_cart", kCart, {"slide"},
                                                 {{EffectId::kRotorInertia, 0, {2.0}}, {EffectId::kViscous, 0, {8.0}}});
  const TorqueVerdict verdict = judge_torque(e, 1);
  ASSERT_EQ(verdict.evidence.findings.size(), 2u);
  for (const Finding& f : verdict.evidence.findings) {
    if (f.effect == "viscous_friction") continue;
    EXPECT_EQ(f.grade, Grade::kAmbiguous) << f.statement;
    EXPECT_FALSE(f.alternatives.empty()) << f.statement;
    // Alternatives are as well known as the finding: the recordings have no noise to speak of.
    for (const Alternative& a : f.alternatives) {
      for (const Estimate& p : a.parameters) EXPECT_LE(p.std[0], 0.05 * std::abs(p.value[0])) << a.effect << " " << p.name;
    }
  }
}

// The axis stands upright, so gravity loads nothing, and the bodies take a tenth of the effort: the drive moves its own rotor.
TEST(TorqueEvidence, FrictionOfTheLoadOfADriveThatMovesItsOwnRotorGrowsWithItsEffort) {
  const char* const table = R"(<robot name="table"><link name="base"/>
      <link name="plate"><inertial><mass value="2"/>
        <inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.05"/></inertial></link>
      <joint name="turn" type="revolute"><parent link="base"/><child link="plate"/><axis xyz="0 0 1"/>
        <limit lower="-3" upper="3" effort="500" velocity="10"/></joint></robot>)";
  const Experiment e = make_simulated_experiment("torque_table", table, {"turn"},
                                                 {{EffectId::kRotorInertia, 0, {0.5}}, {EffectId::kViscous, 0, {0.3}}, {EffectId::kLoadFriction, 0, {0.12, 1e-5}}});
  const TorqueVerdict verdict = judge_torque(e, 1);
  const Finding* friction = find(verdict, "load_dependent_friction", "turn");
  const Finding* rotor = find(verdict, "rotor_inertia", "turn");
  ASSERT_NE(friction, nullptr);
  ASSERT_NE(rotor, nullptr);
  EXPECT_NEAR(friction->parameters[0].value[0], 0.12, 0.012) << friction->statement;  // a tenth: reversals are filtered
  EXPECT_NEAR(rotor->parameters[0].value[0], 0.5, 0.01) << rotor->statement;
}

// From measured efforts a simulation drifts within seconds; over half a second the right model is near the recording.
TEST(TorqueEvidence, WindowsOfTheTrueModelAreTenTimesNearerThanNominalOnes) {
  const Hypothesis hidden = make_drives();
  Experiment e = make_simulated_experiment("torque_windows", kArm, kJoints, hidden);
  e.scenario.drive = "effort";
  const Problem problem = make_problem(e, 1);
  const auto errors = [&](const Hypothesis& h) {
    return calc_window_errors(make_plant(e, h), e, problem.smooth, problem.train, 1);
  };
  const WindowErrors nominal = errors({}), right = errors(hidden);
  EXPECT_GT(nominal.windows, 5);
  for (size_t j = 0; j < kJoints.size(); ++j) EXPECT_LT(right.rms[j], 0.1 * nominal.rms[j]) << kJoints[j];
}

// The comparison of models: what friction and rotors take is taken once.
TEST(TorqueEvidence, EffortsOfTheTrueModelAreMissedByATenthOfNominalOnes) {
  const Hypothesis hidden = make_drives();
  const Experiment e = make_simulated_experiment("torque_residual", kArm, kJoints, hidden);
  const TorqueData data = make_torque_data(e);
  const std::vector<double> nominal = calc_torque_residuals(data, make_plant(e, {}), true),
                            right = calc_torque_residuals(data, make_plant(e, hidden), true);
  // A tenth: reversals that the filter blurs, and noise of accelerations.
  for (size_t j = 0; j < kJoints.size(); ++j) EXPECT_LT(right[j], 0.1 * nominal[j]) << kJoints[j];
}

TEST(TorqueEvidence, AFrozenLogIsLeftOutWithAWarning) {
  const Hypothesis hidden = make_drives();
  Experiment e = make_simulated_experiment("torque_frozen", kArm, kJoints, hidden);
  Recording& r = e.recordings[0];
  for (JointColumns& joint : r.joints) {
    for (size_t k = r.size() / 2; k < r.size(); ++k) {
      joint.signal[0][k] = joint.signal[0][r.size() / 2], joint.signal[1][k] = 0.0;
      joint.signal[2][k] = k % 40 < 20 ? 50.0 : -50.0;
    }
  }
  const TorqueVerdict verdict = judge_torque(e, 1);
  EXPECT_THAT(verdict.evidence.warnings, testing::Contains(testing::HasSubstr("no joint moves")));
  expect_drives(verdict, hidden);
}

}  // namespace
}  // namespace hrp::diagnosis
