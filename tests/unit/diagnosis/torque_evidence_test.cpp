// SPDX-License-Identifier: BSD-3-Clause
// Torque space: friction and rotors of every joint come out with their sizes beside physics of no list; what the
// recordings cannot tell apart is listed; what is not there is not claimed.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <random>

#include "diagnosis/evidence/polish.h"
#include "diagnosis/evidence/torque/bristles.h"
#include "diagnosis/evidence/torque/intervals.h"
#include "diagnosis/evidence/torque/misleading.h"
#include "diagnosis/measurement/torque/residual.h"
#include "diagnosis/search/problem.h"
#include "diagnosis/simulation/windows.h"
#include "tests/test_places.h"
#include "tests/unit/diagnosis/torque_verdicts.h"

namespace hrp::diagnosis {
namespace {

// Cutoff of the torque stage for an arm whose encoders have steps of 1.5 mrad, 4096 a turn [Hz].
double find_coarse_cutoff(const std::string& name, const Hypothesis& hidden) {
  Experiment e = make_simulated_experiment(name, kArm, kArmJoints, hidden);
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
  const double much = find_coarse_cutoff("coarse_much", {{EffectId::kViscous, kShoulder, {2.0}},
                                                         {EffectId::kCoulomb, kShoulder, {3.0, 0.0, 5e-4}},
                                                         {EffectId::kViscous, kElbow, {1.0}},
                                                         {EffectId::kCoulomb, kElbow, {2.0, 0.0, 5e-4}}});
  const double little = find_coarse_cutoff(
      "coarse_little", {{EffectId::kViscous, kShoulder, {0.02}}, {EffectId::kViscous, kElbow, {0.01}}});
  EXPECT_LT(little, much);
}

// A level of dry friction and a hysteresis at the elbow, which travels by radians.
std::vector<Finding> find_bent(double yield) {
  const Experiment e = make_simulated_experiment("bristles", kArm, kArmJoints, {});
  const Where elbow = {{"joint", "elbow"}};
  Finding dry = make_finding(get_effect(EffectId::kCoulomb), elbow, {make_one("level", "N m", 0.06, 0.005)});
  Finding bent =
      make_finding(get_effect(EffectId::kHysteresis), elbow,
                   {make_one("stiffness", "N m/rad", 0.04 / yield, 0.0), make_one("yield_angle", "rad", yield, 0.0)});
  std::vector<Finding> findings{dry, bent};
  join_bristles(make_torque_data(e), &findings);
  return findings;
}

TEST(TorqueEvidence, DryFrictionThatBendsBeforeItSlipsIsOneCauseWithItsWholeLevel) {
  const std::vector<Finding> one = find_bent(0.003);
  ASSERT_EQ(one.size(), 1u);
  EXPECT_NEAR(one[0].parameters[0].value[0], 0.10, 1e-12);
  EXPECT_EQ(one[0].alternatives.at(0).effect, "hysteresis");
  EXPECT_EQ(find_bent(0.3).size(), 2u);  // such a spring is told from friction
}

TEST(TorqueEvidence, FrictionAndRotorsOfEveryJointComeOutBesideTextureOfNoList) {
  const Hypothesis hidden = make_arm_drives();
  Experiment e = make_simulated_experiment("torque_dirty", kArm, kArmJoints, hidden);
  add_texture(0.1, &e);
  const TorqueVerdict verdict = judge_torque(e, 1);
  ASSERT_TRUE(verdict.judged);
  EXPECT_EQ(verdict.with_drives, 2);
  expect_drives(verdict, hidden);
}

// A joint that turned one way: a constant torque of 1600 N m was listed, which dry friction of 1580 N m took back. The
// drive gives 330 N m.
TEST(TorqueEvidence, ATermThatOthersTakeBackButForADetailIsNotPhysical) {
  const Experiment e = simulate_arm("torque_back", make_arm_drives());
  const TorqueDesign design = make_torque_design(make_torque_data(e));
  std::vector<size_t> pair;
  Eigen::Vector2d signs;
  for (size_t t = 0; t < design.joints[kShoulder].terms.size(); ++t) {
    const TermRow& row = *design.joints[kShoulder].terms[t].row;
    if (!row.is_constant() && !row.level) continue;
    ASSERT_LT(pair.size(), 2u);
    signs[static_cast<long>(pair.size())] = row.level ? 1.0 : -1.0;
    pair.push_back(t);
  }
  ASSERT_EQ(pair.size(), 2u);
  EXPECT_TRUE(is_physical(design, kShoulder, pair, 1.5 * signs));  // its friction
  EXPECT_FALSE(is_physical(design, kShoulder, pair, 1600.0 * signs));
}

// Before, recordings below a second were left to a search of sets of few effects, which reported that no effect
// explains them.
TEST(TorqueEvidence, StepsOfLessThanASecondShowFrictionAndRotors) {
  Experiment e = make_simulated_experiment("torque_steps", kArm, kArmJoints, make_arm_drives());
  constexpr long kFirst = 500, kSamples = 180;  // 0.9 s of 6 s, in motion
  for (Recording& r : e.recordings) {
    const auto cut = [](std::vector<double>* column) {
      *column = {column->begin() + kFirst, column->begin() + kFirst + kSamples};
    };
    cut(&r.time);
    for (JointColumns& joint : r.joints) {
      for (std::vector<double>* column :
           {&joint.command, &joint.command_rate, &joint.signal[0], &joint.signal[1], &joint.signal[2]})
        cut(column);
    }
  }
  const TorqueVerdict verdict = judge_torque(e, 1);
  ASSERT_TRUE(verdict.judged);
  EXPECT_GT(verdict.evidence.explained, 0.9);
  for (const std::string& joint : kArmJoints) EXPECT_NE(find(verdict, "rotor_inertia", joint), nullptr) << joint;
}

// Before, friction took its place: three times too large, and a rotor too small by a fifth.
TEST(TorqueEvidence, HysteresisIsNamedAndLeavesFrictionAndRotorTheirSizes) {
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kHysteresis, kShoulder, {60.0, 0.02}});
  const TorqueVerdict verdict =
      judge_torque(make_simulated_experiment("torque_hysteresis", kArm, kArmJoints, hidden), 1);
  const Finding* f = find(verdict, "hysteresis", "shoulder");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->grade, Grade::kSupported) << f->statement;
  // Yield angles are tried by factors of 1.5, and the filter rounds the element's corners.
  EXPECT_NEAR(f->parameters[0].value[0] * f->parameters[1].value[0], 1.2, 0.3) << f->statement;
  EXPECT_NEAR(f->parameters[1].value[0], 0.02, 0.01) << f->statement;
  EXPECT_EQ(find(verdict, "hysteresis", "elbow"), nullptr);
  for (const Effect& truth : make_arm_drives()) {
    const Finding* drive = find(verdict, get_effect(truth.id).name, kArmJoints[static_cast<size_t>(truth.place.index)]);
    ASSERT_NE(drive, nullptr) << get_effect(truth.id).name;
    EXPECT_NEAR(drive->parameters[0].value[0], truth.p[0], 0.2 * truth.p[0]) << drive->statement;
  }
}

// Bristles bend by 3 mrad before they slip, six times what the tool assumes: all friction has that memory.
TEST(TorqueEvidence, PreSlidingOfDryFrictionIsNoHysteresis) {
  Hypothesis hidden = make_arm_drives();
  for (Effect& effect : hidden) {
    if (effect.id == EffectId::kCoulomb) effect.p[2] = 3e-3;
  }
  const TorqueVerdict verdict =
      judge_torque(make_simulated_experiment("torque_presliding", kArm, kArmJoints, hidden), 1);
  for (const std::string& joint : kArmJoints) EXPECT_EQ(find(verdict, "hysteresis", joint), nullptr) << joint;
}

// Twelve windows of a turn with a friction of their own, of which a joint sees the first: a joint that hardly moves
// knows its level to 38 %, one that sees a whole turn exactly.
TEST(TorqueEvidence, DryFrictionOfAPartOfATurnIsKnownAsWellAsAFewOfItsWindowsTellTheMean) {
  constexpr int kWindows = 12, kTurns = 20000;
  const auto calc_spread = [&](int seen) {
    std::mt19937 random(7);
    std::normal_distribution<double> level(1.0, 0.2);
    double square = 0.0;
    for (int turn = 0; turn < kTurns; ++turn) {
      double all = 0.0, part = 0.0;
      for (int w = 0; w < kWindows; ++w) {
        const double own = level(random);
        all += own / kWindows;
        part += w < seen ? own / seen : 0.0;
      }
      square += (part - all) * (part - all) / kTurns;
    }
    return std::sqrt(square);
  };
  for (int seen : {1, 3, 6, 12}) EXPECT_NEAR(calc_unseen_std(1.0, seen * M_PI / 6.0), calc_spread(seen), 0.005) << seen;
  EXPECT_NEAR(calc_unseen_std(-5.0, 0.02), 1.0, 0.01);
}

// Hip yaws of standing robots stand still: the report was silent about them.
TEST(TorqueEvidence, OfAJointThatStandsStillTheReportSaysThatThisMotionCannotTellItsDrive) {
  Experiment e = simulate_arm("evidence_still", make_arm_drives());
  for (Recording& r : e.recordings) {
    JointColumns& elbow = r.joints[1];
    for (size_t k = 0; k < r.size(); ++k) {
      elbow.signal[0][k] = 0.3;
      elbow.signal[1][k] = 0.0;
    }
  }
  const std::vector<NotIdentifiable> list = judge_torque(e, 1).evidence.not_identifiable;
  const auto says = [&](const char* joint) {
    return std::any_of(list.begin(), list.end(), [&](const NotIdentifiable& n) {
      return n.effect == get_effect(EffectId::kRotorInertia).name && n.where == Where{{"joint", joint}} &&
             n.why.find("hardly moves") != std::string::npos;
    });
  };
  EXPECT_TRUE(says("elbow"));
  EXPECT_FALSE(says("shoulder"));
}

TEST(TorqueEvidence, NothingHiddenGivesNoFinding) {
  const Experiment e = make_simulated_experiment("torque_none", kArm, kArmJoints, {});
  const TorqueVerdict verdict = judge_torque(e, 1);
  EXPECT_TRUE(verdict.evidence.findings.empty()) << verdict.evidence.findings[0].statement;
}

// Friction of 0.8 N m (1 +- 0.3): moving and at rest the same as 0.8 N m beside a constant torque of 0.24 N m.
TEST(TorqueEvidence, AConstantTorqueIsAmongOthersFrictionThatHoldsMoreInOneDirection) {
  Hypothesis hidden = make_arm_drives();
  hidden[4].p[1] = 0.3;
  const TorqueVerdict verdict =
      judge_torque(make_simulated_experiment("torque_one_sided", kArm, kArmJoints, hidden), 1);
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

// Before, the sum was 1.2: the gain's share was below nothing, so that friction took away more than there was.
TEST(TorqueEvidence, SharesOfAJointWhoseGainIsWrongAddUpToOne) {
  Hypothesis hidden = make_arm_drives();
  hidden[0].p[0] *= 4.0;
  hidden[1].p[0] *= 4.0;  // most of the effort: alone, a gain would take it for a weak drive
  hidden.push_back({EffectId::kTorqueConstant, kShoulder, {0.9}});
  Experiment e = simulate_arm("torque_gain_shares", hidden);
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) forget_commands(&r);
  double sum = 0.0;
  for (const Finding& f : judge_torque(e, 1).evidence.findings) {
    if (f.where.begin().value() == "shoulder") sum += f.share;
  }
  EXPECT_NEAR(sum, 1.0, 0.02);  // what remains
}

// Held-out recordings refuse it, so nobody reads of it: friction and rotor would be this factor too small.
TEST(TorqueEvidence, AGainThatHeldOutRecordingsRefuseLeavesTheModel) {
  Experiment e = simulate_arm("torque_refused_gain", make_arm_drives());
  TorqueDesign design = make_torque_design(make_torque_data(e));
  Choice choice = choose_torque_model(design, 1);
  const auto& terms = design.joints[kShoulder].terms;
  const auto is_gain = [&](size_t term) { return terms[term].row->scales_effort; };
  size_t gain = 0;
  while (!is_gain(gain)) ++gain;
  std::vector<size_t>& own = choice.model.own[kShoulder];
  own.push_back(gain);
  std::sort(own.begin(), own.end());
  choice.fit = fit_torque(design, choice.model);
  choice.fit.held[kShoulder] *= 1.1;
  GradedTerm refused;
  refused.term = terms[gain];
  refused.place = {kShoulder, 0};
  refused.helps_held = false;
  EXPECT_TRUE(drop_false_gains(1, {refused}, &design, &choice));
  EXPECT_TRUE(std::none_of(choice.model.own[kShoulder].begin(), choice.model.own[kShoulder].end(), is_gain));
}

// Springs that carry a part of an arm, and efforts of a log that leaves all of gravity out.
TEST(TorqueEvidence, WhatCarriesTheLinksBesideTheDrivesIsNamedWithItsShare) {
  for (const double share : {0.6, 1.0}) {
    Hypothesis hidden = make_arm_drives();
    hidden.push_back({find_effect("gravity_compensation")->id, 0, {share}});
    const TorqueVerdict verdict =
        judge_torque(make_simulated_experiment("torque_carried", kArm, kArmJoints, hidden), 1);
    const Finding* carried = find(verdict, "gravity_compensation", "base");
    ASSERT_NE(carried, nullptr) << share;
    EXPECT_EQ(carried->grade, Grade::kSupported) << carried->statement;
    EXPECT_NEAR(carried->parameters[0].value[0], share, 0.02);  // three deviations of the spread between recordings
    EXPECT_EQ(find(verdict, "base_tilt", "base"), nullptr);
    for (const char* link : {"upper", "fore"}) EXPECT_EQ(find(verdict, "external_force", link), nullptr);
  }
}

// What a joint's rotor is beside a wrong mass is another number than alone: it must still be one.
TEST(TorqueEvidence, OfARealArmWithOneRecordingNoRotorWeighsLessThanNothing) {
  const std::filesystem::path path =
      std::filesystem::path(source_dir()) / "../shared/recordings/dfki_double_pendulum/experiment.yaml";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  Experiment e = load_experiment(path.string());
  e.recordings.resize(1);
  for (const Finding& f : judge_torque(e, 1).evidence.findings) {
    if (f.effect != "rotor_inertia") continue;
    EXPECT_GT(f.parameters[0].value[0], 0.0) << f.statement;
  }
}

// What a drive does late hardly shows in its missing torque; its simulated motion tells it.
TEST(TorqueEvidence, ALagBesideFrictionIsFoundThroughTheJointsSimulation) {
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kLag, kElbow, {0.02}});
  const Experiment e = make_simulated_experiment("torque_lag", kArm, kArmJoints, hidden);
  const Hypothesis found = polish_joints(make_problem(e, 1), make_arm_drives(), nullptr, true);
  const auto lag = std::find_if(found.begin(), found.end(),
                                [](const Effect& x) { return x.id == EffectId::kLag || x.id == EffectId::kDelay; });
  ASSERT_NE(lag, found.end());
  EXPECT_EQ(lag->place, at_joint(kElbow));
  EXPECT_NEAR(lag->p[0], 0.02, 0.004);  // a delay of as many milliseconds does nearly the same below 5 Hz
}

void add_spring(double stiffness, Recording* r) {
  JointColumns& elbow = r->joints[kElbow];
  for (size_t k = 0; k < r->size(); ++k) elbow.signal[2][k] += stiffness * elbow.signal[0][k];
  forget_commands(r);
}

// Held-out recordings together are predicted better with the spring, the last one worse: it is no property of the
// joint.
TEST(TorqueEvidence, ASpringThatOneHeldOutRecordingDeniesIsNotSupported) {
  Experiment e = make_simulated_experiment("torque_denied", kArm, kArmJoints, make_arm_drives());
  e.recordings.push_back(e.recordings[2]);
  add_spring(5.0, &e.recordings[0]);
  add_spring(5.0, &e.recordings[1]);
  Experiment agreed = e;
  add_spring(8.0, &e.recordings[2]);
  add_spring(-1.0, &e.recordings[3]);
  add_spring(5.0, &agreed.recordings[2]);
  add_spring(5.0, &agreed.recordings[3]);
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
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kPayload, kFore, {0.8, 0.3, 0.0, 0.0, 0.0}});
  Experiment e = make_simulated_experiment("torque_single", kArm, kArmJoints, hidden);
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
    // The recordings have no noise to speak of. What counts is that torque constants, and masses of links, are known to
    // 2 %: of 2 kg beside a cart of 5 kg, hypot(0.02 * 7, 0.02 * 5) = 0.172 kg.
    for (const Alternative& a : f.alternatives) {
      for (const Estimate& p : a.parameters)
        EXPECT_LE(p.std[0], 0.09 * std::abs(p.value[0])) << a.effect << " " << p.name;
    }
  }
}

// The axis stands upright, so gravity loads nothing, and the bodies take a tenth of the effort: the drive moves its own
// rotor.
TEST(TorqueEvidence, FrictionOfTheLoadOfADriveThatMovesItsOwnRotorGrowsWithItsEffort) {
  const char* const table = R"(<robot name="table"><link name="base"/>
      <link name="plate"><inertial><mass value="2"/>
        <inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.05"/></inertial></link>
      <joint name="turn" type="revolute"><parent link="base"/><child link="plate"/><axis xyz="0 0 1"/>
        <limit lower="-3" upper="3" effort="500" velocity="10"/></joint></robot>)";
  const Experiment e = make_simulated_experiment("torque_table", table, {"turn"},
                                                 {{EffectId::kRotorInertia, 0, {0.5}},
                                                  {EffectId::kViscous, 0, {0.3}},
                                                  {EffectId::kLoadFriction, 0, {0.12, 1e-5}}});
  const TorqueVerdict verdict = judge_torque(e, 1);
  const Finding* friction = find(verdict, "load_dependent_friction", "turn");
  const Finding* rotor = find(verdict, "rotor_inertia", "turn");
  ASSERT_NE(friction, nullptr);
  ASSERT_NE(rotor, nullptr);
  EXPECT_NEAR(friction->parameters[0].value[0], 0.12, 0.012) << friction->statement;  // a tenth: reversals are filtered
  EXPECT_NEAR(rotor->parameters[0].value[0], 0.5, 0.01) << rotor->statement;
}

// The spring takes most of the effort, so the gear's load is not that of the bodies. With the bodies' load, two zeros
// of joints, a constant torque and a force explained more.
TEST(TorqueEvidence, FrictionOfTheLoadBesideASpringGrowsWithWhatTheDriveGives) {
  Hypothesis hidden{{EffectId::kSpring, kShoulder, {40.0, 0.2}}, {EffectId::kLoadFriction, kShoulder, {0.1, 1e-5}}};
  for (const Effect& effect : make_arm_drives()) hidden.push_back(effect);
  const TorqueVerdict verdict = judge_torque(make_simulated_experiment("torque_spring", kArm, kArmJoints, hidden), 1);
  const Finding* friction = find(verdict, "load_dependent_friction", "shoulder");
  const Finding* spring = find(verdict, "parallel_spring", "shoulder");
  ASSERT_NE(friction, nullptr);
  ASSERT_NE(spring, nullptr);
  EXPECT_NEAR(friction->parameters[0].value[0], 0.1, 0.015) << friction->statement;  // as above; the level takes some
  EXPECT_NEAR(spring->parameters[0].value[0], 40.0, 1.2) << spring->statement;
}

// The nominal bodies load the gear otherwise than the true ones, and no law of the drive contains the difference. With
// their load, the centre of mass was 28 mm off, with a force of 1.8 N beside it.
TEST(TorqueEvidence, FrictionOfTheLoadBesideAWrongCentreOfMassCountsTheTrueLoad) {
  const Hypothesis hidden{{EffectId::kComError, kFore, {-0.1, 0.0, 0.1}},
                          {EffectId::kLoadFriction, kElbow, {0.1, 1e-5}},
                          {EffectId::kViscous, kElbow, {0.1}},
                          {EffectId::kRotorInertia, kElbow, {0.02}},
                          {EffectId::kCoulomb, kElbow, {0.1, 0.0, 5e-4}}};
  const TorqueVerdict verdict = judge_torque(make_simulated_experiment("torque_com", kArm, kArmJoints, hidden), 1);
  const Finding* centre = find(verdict, "com_error", "fore");
  ASSERT_NE(centre, nullptr);
  // The term is linear in the offset; the inertia's second order, m |offset|^2, is a rotor of 0.02 kg m^2 in addition.
  EXPECT_NEAR(centre->parameters[0].value[0], -0.1, 0.005) << centre->statement;
  EXPECT_NEAR(centre->parameters[0].value[2], 0.1, 0.005) << centre->statement;
  for (const char* link : {"upper", "fore"}) EXPECT_EQ(find(verdict, "external_force", link), nullptr);
}

// From measured efforts a simulation drifts within seconds; over half a second the right model is near the recording.
TEST(TorqueEvidence, WindowsOfTheTrueModelAreTenTimesNearerThanNominalOnes) {
  const Hypothesis hidden = make_arm_drives();
  Experiment e = make_simulated_experiment("torque_windows", kArm, kArmJoints, hidden);
  e.scenario.drive = "effort";
  const Problem problem = make_problem(e, 1);
  const auto errors = [&](const Hypothesis& h) {
    return calc_window_errors(make_plant(e, h), e, problem.smooth, problem.train, 1);
  };
  const WindowErrors nominal = errors({}), right = errors(hidden);
  EXPECT_GT(nominal.windows, 5);
  for (size_t j = 0; j < kArmJoints.size(); ++j) EXPECT_LT(right.rms[j], 0.1 * nominal.rms[j]) << kArmJoints[j];
}

// The comparison of models: what friction and rotors take is taken once.
TEST(TorqueEvidence, EffortsOfTheTrueModelAreMissedByATenthOfNominalOnes) {
  const Hypothesis hidden = make_arm_drives();
  const Experiment e = make_simulated_experiment("torque_residual", kArm, kArmJoints, hidden);
  const TorqueData data = make_torque_data(e);
  const std::vector<double> nominal = calc_torque_residuals(data, make_plant(e, {}), true),
                            right = calc_torque_residuals(data, make_plant(e, hidden), true);
  // A tenth: reversals that the filter blurs, and noise of accelerations.
  for (size_t j = 0; j < kArmJoints.size(); ++j) EXPECT_LT(right[j], 0.1 * nominal[j]) << kArmJoints[j];
}

}  // namespace
}  // namespace hrp::diagnosis
