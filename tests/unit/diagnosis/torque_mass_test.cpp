// SPDX-License-Identifier: BSD-3-Clause
// Masses, loads, gains and gears in torque space: which of them takes the torque, and what else might.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/data/stretches.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/torque/gain_spread.h"
#include "diagnosis/evidence/torque/gears.h"
#include "diagnosis/evidence/torque/grade.h"
#include "diagnosis/evidence/torque/intervals.h"
#include "tests/shared_files.h"
#include "tests/unit/diagnosis/torque_verdicts.h"

namespace hrp::diagnosis {
namespace {

TEST(TorqueMass, ALoadInTheHandIsNamedAtItsLinkWithItsMass) {
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kPayload, kFore, {0.8, 0.3, 0.0, 0.0, 0.0}});
  const Experiment e = make_simulated_experiment("torque_load", kArm, kArmJoints, hidden);
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
TEST(TorqueMass, ALoadFarFromTheLinksCentreOfMassHasItsMassAndPlace) {
  Hypothesis hidden = make_arm_drives();
  constexpr double kMass = 0.8, kFar = 0.35;  // [kg]; [m], 0.15 the centre of mass
  hidden.push_back({EffectId::kPayload, kFore, {kMass, kFar, 0.0, 0.05, 0.0}});
  const Experiment e = make_simulated_experiment("torque_far_load", kArm, kArmJoints, hidden);
  const TorqueVerdict verdict = judge_torque(e, 1);
  const Finding* f = find(verdict, "payload", "fore");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(f->grade, Grade::kSupported) << f->statement;
  // 5 %: with its inertia taken at the link's centre of mass the wrong effects were named.
  EXPECT_NEAR(f->parameters[0].value[0], kMass, 0.05 * kMass) << f->statement;
  EXPECT_NEAR(f->parameters[1].value[0], kFar, 0.05 * kFar) << f->statement;
}

// A tool that is not on the robot any more. With a tenth of the friction in no list a force was named in its place.
TEST(TorqueMass, ALinkOfTwoFifthsOfItsMassHasAWrongMassAndNoForceOnIt) {
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kMassError, kFore, {0.4}});
  Experiment e = make_simulated_experiment("torque_light", kArm, kArmJoints, hidden);
  add_texture(0.2, &e);
  const TorqueVerdict verdict = judge_torque(e, 1);
  const Finding* f = find(verdict, "mass_error", "fore");
  ASSERT_NE(f, nullptr);
  EXPECT_NEAR(f->parameters[0].value[0], 0.4, 0.02);  // a thirtieth of what is missing; texture belongs to friction
  EXPECT_EQ(find(verdict, "external_force", "fore"), nullptr);
}

// Adds a term of the joint's own to a model. Returns its place in the list.
size_t add_own(const TorqueDesign& design, size_t joint, bool (*is_it)(const Term&), TorqueModel* model) {
  const std::vector<Term>& terms = design.joints[joint].terms;
  return add_own_term(joint, static_cast<size_t>(std::find_if(terms.begin(), terms.end(), is_it) - terms.begin()),
                      model);
}

// A robot whose shoulder gives 0.86 of its log. Whoever cannot see the elbow's gain has no reason to trust that log
// more.
TEST(TorqueMass, AnUnseenTorqueConstantIsKnownNoBetterThanThoseOfTheOtherDrivesAreRight) {
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kTorqueConstant, kShoulder, {0.86}});
  Experiment e = make_simulated_experiment("torque_unseen_gain", kArm, kArmJoints, hidden);
  for (Recording& r : e.recordings) forget_commands(&r);
  TorqueDesign design = make_torque_design(make_torque_data(e));
  TorqueModel model;
  model.own = list_usual_terms(design);
  EXPECT_THAT(calc_gain_std(design, model, fit_torque(design, model)), testing::Each(kKnown));
  add_own(
      design, kShoulder, [](const Term& t) { return t.row->scales_effort; }, &model);
  const TorqueFit fit = fit_torque(design, model);
  ASSERT_TRUE(design.joints[kElbow].loaded);
  const std::vector<double> seen = calc_gain_std(design, model, fit);
  EXPECT_EQ(seen[kShoulder], kKnown);  // fitted: its own interval says how well it is known
  EXPECT_LT(seen[kElbow], 0.05);       // the weight of the fore link shows that it is right
  design.joints[kElbow].loaded = false;
  EXPECT_NEAR(calc_gain_std(design, model, fit)[kElbow], 0.14 * std::sqrt(2.0),
              0.03);  // one more drive than the one that is known; the gain is found to 0.02
}

// A stretch of one joint's rows takes a mass for a gain: with the mass free in each, the gain's size was lost.
TEST(TorqueMass, AGainBesideAWrongMassIsAsSureAsTheRowsOfAllJointsTellIt) {
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kMassError, kFore, {1.25}});
  hidden.push_back({EffectId::kTorqueConstant, kElbow, {0.95}});
  Experiment e = make_simulated_experiment("torque_gain_and_mass", kArm, kArmJoints, hidden);
  for (Recording& r : e.recordings) forget_commands(&r);
  const TorqueDesign design = make_torque_design(make_torque_data(e));
  Choice choice;
  choice.model.own = list_usual_terms(design);
  for (const JointDesign& joint : design.joints) {
    choice.inclusion.emplace_back(joint.terms.size(), 1.0);
    choice.choice_std.emplace_back(joint.terms.size(), 0.0);
  }
  const size_t at = add_own(
      design, kElbow, [](const Term& t) { return t.row->scales_effort; }, &choice.model);
  const auto is_mass = [](const Term& t) { return t.row->factor && t.place == kFore; };
  choice.model.whole = {
      static_cast<size_t>(std::find_if(design.whole.begin(), design.whole.end(), is_mass) - design.whole.begin())};
  choice.fit = fit_torque(design, choice.model);
  const GradedTerm graded = grade_term(design, choice, {kElbow, at});
  EXPECT_NEAR(1.0 - graded.parameters[0], 0.95, kNinetyFive * graded.width[0]);
  EXPECT_LT(graded.width[0], 0.03);  // 2 % of the constant and what the friction leaves
  EXPECT_GE(graded.agreement, kMostly);
}

// A constant torque of a hundredth of the effort was supported where a centre of mass lay 3 mm across its link.
TEST(TorqueMass, AConstantTorqueIsKnownNoBetterThanTheWeightThatMakesOne) {
  const Experiment e = make_simulated_experiment("torque_constant_width", kArm, kArmJoints, make_arm_drives());
  const TorqueDesign design = make_torque_design(make_torque_data(e));
  TorqueModel model{list_usual_terms(design), {}};
  const size_t at = add_own(
      design, kElbow, [](const Term& t) { return t.row->is_constant(); }, &model);
  const Eigen::VectorXd std = calc_unsure_mass_std(design, model, fit_torque(design, model));
  constexpr double kWeight = 1.0 * 9.81 * 0.15;  // [N m] of the forearm, held level
  const double constant = std[list_slots(design, model).own[kElbow][at]];
  EXPECT_GT(constant, 0.3 * kKnown * kWeight);  // what other positions tell of it
  EXPECT_LT(constant, 1.5 * kKnown * kWeight);  // across the link and along it
}

// Held postures tell the moment of a load and hardly its mass.
TEST(TorqueMass, ThePlaceOfALoadIsKnownNoBetterThanItsMass) {
  const Eigen::Vector4d load(0.5, 0.05, 0.0, 0.0), width(0.1, 0.002, 0.0, 0.0);
  EXPECT_NEAR(take_place_widths(load, Eigen::Vector4d(0.01, 4e-6, 0, 0).asDiagonal(), width)[1] / load[0], 0.02,
              0.001);  // 20 % of 0.1 m
  // A known place: mass and moment are off together.
  Eigen::Matrix4d together = Eigen::Vector4d(0.01, 1e-4, 0, 0).asDiagonal();
  together(0, 1) = together(1, 0) = 1e-3;
  EXPECT_NEAR(take_place_widths(load, together, {0.1, 0.01, 0.0, 0.0})[1], 0.0, 1e-9);
}

// A load that nobody stated makes every drive before it look weak: alone it does what all their gains do together.
TEST(TorqueMass, GainsOfAnArmThatCarriesALoadHaveTheLoadAsTheirAlternative) {
  std::string light = kArm;  // all that both drives carry is the forearm
  const std::string upper = "<mass value=\"2\"/>";
  light.replace(light.find(upper), upper.size(), "<mass value=\"0.2\"/>");
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kPayload, kFore, {0.2, 0.15, 0.0, 0.0, 0.0}});
  Experiment e = make_simulated_experiment("torque_gain_or_load", light, kArmJoints, hidden);
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
    const bool listed =
        std::any_of(g.rivals.begin(), g.rivals.end(), [](const Rival& r) { return r.term.row->is_of_mass(); });
    EXPECT_TRUE(listed) << "gain of " << kArmJoints[static_cast<size_t>(g.term.place)];
  }
}

// Drives that give 2 % less than their data sheets say make every mass look 2 % larger: that much no mass is known
// better.
TEST(TorqueMass, AMassIsKnownNoBetterThanTheTorqueConstantsOfTheDrivesThatCarryIt) {
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kMassError, kFore, {0.65}});
  Experiment e = simulate_currents("torque_known", hidden, {0.98, 0.98});
  for (Recording& r : e.recordings) forget_commands(&r);
  const TorqueVerdict verdict = judge_torque(e, 1);
  const Finding* f = find(verdict, "mass_error", "fore");
  ASSERT_NE(f, nullptr);
  const Estimate& scale = f->parameters[0];
  EXPECT_GT(scale.value[0], 0.655) << f->statement;  // so that the next line says something
  EXPECT_LT(std::abs(scale.value[0] - 0.65), 1.96 * scale.std[0]) << f->statement;
}

// kArm on a plumb first axis. All that gravity pulls on is the forearm.
std::string make_turning_arm() {
  std::string arm = kArm;
  const std::string axis = "<axis xyz=\"0 1 0\"/>";
  return arm.replace(arm.find(axis), axis.size(), "<axis xyz=\"0 0 1\"/>");
}

// Efforts that are currents of drives with 1.3 N m/A: to a plumb first axis and the joint behind it, a light forearm
// and a rotor say the same.
TEST(TorqueMass, ALinkThatLooksLightHasTheGainsOfAllDrivesThatMoveItAsAlternatives) {
  Hypothesis hidden{{EffectId::kViscous, kShoulder, {0.2}},
                    {EffectId::kCoulomb, kShoulder, {0.3, 0.0, 5e-4}},
                    {EffectId::kViscous, kElbow, {0.05}},
                    {EffectId::kCoulomb, kElbow, {0.1, 0.0, 5e-4}}};
  Experiment e = make_simulated_experiment("torque_all_gains", make_turning_arm(), kArmJoints, hidden);
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) {
    forget_commands(&r);
    for (JointColumns& joint : r.joints) {
      for (double& y : joint.signal[2]) y /= 1.3;
    }
  }
  const TorqueDesign design = make_torque_design(make_torque_data(e));
  Choice choice = choose_torque_model(design, 1);
  const auto mass = std::find_if(design.whole.begin(), design.whole.end(),
                                 [](const Term& t) { return t.row->factor && t.place == kFore; });
  ASSERT_NE(mass, design.whole.end());
  choice.model = {list_usual_terms(design), {static_cast<size_t>(mass - design.whole.begin())}};
  choice.fit = fit_torque(design, choice.model);
  const GradedTerm g = grade_term(design, choice, {-1, 0});
  EXPECT_EQ(g.grade, Grade::kAmbiguous);
  std::vector<int> joints;
  for (const Rival& r : g.rivals) {
    if (!r.term.row->scales_model) continue;
    joints.push_back(r.term.place);
    EXPECT_NEAR(1.0 / (1.0 + r.parameters[0]), 1.3, 0.13);  // a tenth: what a plumb axis takes its rotor may take, too
  }
  EXPECT_THAT(joints, testing::UnorderedElementsAre(kShoulder, kElbow));
}

// A load in the hand moves the centres of mass of the hand's link and, by its weight on the elbow, of the one before.
TEST(TorqueMass, TwoWrongCentresOfMassHaveTheOneLoadThatMovesBothAsAlternative) {
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kPayload, kFore, {0.5, 0.25, 0.0, 0.0, 0.0}});
  Experiment e = make_simulated_experiment("torque_two_centres", kArm, kArmJoints, hidden);
  add_texture(0.1, &e);
  const TorqueDesign design = make_torque_design(make_torque_data(e));
  Choice choice = choose_torque_model(design, 1);
  choice.model = {list_usual_terms(design), {}};
  for (size_t t = 0; t < design.whole.size(); ++t) {
    if (design.whole[t].row->effect->id == EffectId::kComError) choice.model.whole.push_back(t);
  }
  choice.fit = fit_torque(design, choice.model);
  for (const GradedTerm& g : grade_terms(design, choice, 1)) {
    if (!g.term.whole()) continue;
    const auto load = std::find_if(g.rivals.begin(), g.rivals.end(),
                                   [](const Rival& r) { return r.term.row->load && r.term.place == kFore; });
    ASSERT_NE(load, g.rivals.end()) << "link " << g.term.place;
    const double mass = load->parameters[0];
    EXPECT_NEAR(mass, 0.5, 0.05);  // a tenth: texture, and inertia to first order
    EXPECT_NEAR(load->parameters[1] / mass, 0.25, 0.03);
  }
}

// Joints' terms that were chosen beside a force hide the load whose weight it is: a gain takes what the force leaves.
TEST(TorqueMass, AForceThatPointsDownHasTheLoadWhoseWeightItIsAsAlternative) {
  Hypothesis hidden = make_arm_drives();
  hidden.push_back({EffectId::kPayload, kFore, {0.5, 0.25, 0.0, 0.0, 0.0}});
  Experiment e = make_simulated_experiment("torque_weight", kArm, kArmJoints, hidden);
  add_texture(0.1, &e);
  for (Recording& r : e.recordings) forget_commands(&r);
  const TorqueDesign design = make_torque_design(make_torque_data(e));
  Choice choice = choose_torque_model(design, 1);
  choice.model = {list_usual_terms(design), {}};
  for (size_t i : {size_t{kShoulder}, size_t{kElbow}}) {
    add_own(
        design, i, [](const Term& t) { return t.row->scales_effort; }, &choice.model);
    add_own(
        design, i, [](const Term& t) { return t.row->effect->id == EffectId::kSpring; }, &choice.model);
  }
  const auto pulls = std::find_if(design.whole.begin(), design.whole.end(),
                                  [](const Term& t) { return t.row->pulls && t.place == kFore; });
  ASSERT_NE(pulls, design.whole.end());
  choice.model.whole = {static_cast<size_t>(pulls - design.whole.begin())};
  choice.fit = fit_torque(design, choice.model);
  const GradedTerm g = grade_term(design, choice, {-1, 0});
  const auto load = std::find_if(g.rivals.begin(), g.rivals.end(),
                                 [](const Rival& r) { return r.term.row->load && r.term.place == kFore; });
  ASSERT_NE(load, g.rivals.end());
  EXPECT_NEAR(load->parameters[0], 0.5, 0.05);  // a tenth, as above
  EXPECT_NE(g.grade, Grade::kSupported);
}

// A force may have any direction: that it lies within 10 degrees of the vertical is one case of 130, and a weight's
// always.
TEST(TorqueMass, AForceAlongGravityIsLessLikelyThanAWeightByTheConeItLiesIn) {
  const Vector3d gravity_W(0.0, 0.0, -9.81);
  const auto cost = [&](double angle) {
    return calc_direction_cost(5.0 * Vector3d(std::sin(angle), 0.0, -std::cos(angle)), gravity_W);
  };
  EXPECT_NEAR(std::exp(cost(M_PI / 18.0)), 131.6, 0.1);
  EXPECT_NEAR(cost(M_PI / 2.0), std::log(2.0), 1e-12);
  EXPECT_NEAR(cost(M_PI), 0.0, 1e-12);  // up: no weight
  EXPECT_EQ(cost(0.0), cost(0.01));     // no base is so level
  EXPECT_EQ(calc_direction_cost(gravity_W, Vector3d::Zero()), 0.0);
}

// One link alone: a mass that is wrong by a factor and a gain of the drive say the same in every motion.
TEST(TorqueMass, GainAndMassOfASingleLinkAreAmbiguousWithEachOther) {
  const Experiment e =
      make_simulated_experiment("torque_gain", kPendulum, {"hinge"}, {{EffectId::kTorqueConstant, 0, {0.8}}});
  const TorqueVerdict verdict = judge_torque(e, 1);
  ASSERT_EQ(verdict.evidence.findings.size(), 1u);
  const Finding& f = verdict.evidence.findings[0];
  EXPECT_EQ(f.grade, Grade::kAmbiguous) << f.statement;
  std::vector<std::string> all{f.effect};
  for (const Alternative& a : f.alternatives) all.push_back(a.effect);
  EXPECT_THAT(all, testing::IsSupersetOf({"torque_constant_error", "mass_error"}));
}

bool has_mass(const Finding& gain) {
  return std::any_of(gain.alternatives.begin(), gain.alternatives.end(),
                     [](const Alternative& a) { return a.effect == "mass_error"; });
}

// A drive that gives a tenth less than it logs, in short recordings with a little uneven friction: much may stand in
// for a part of its gain, and the list has an end. What says the same in every motion comes first.
TEST(TorqueMass, TheMassOfASingleLinkIsListedBeforeWhatOnlyNearlyFits) {
  for (size_t parts : {2, 3}) {
    Experiment e =
        make_simulated_experiment("torque_uneven", kPendulum, {"hinge"}, {{EffectId::kTorqueConstant, 0, {0.89}}});
    for (Recording& r : e.recordings) r = cut_recording(r, 0, r.size() / parts);
    add_texture(0.1, &e);
    const TorqueVerdict verdict = judge_torque(e, 1);
    const Finding* gain = find(verdict, "torque_constant_error", "hinge");
    ASSERT_NE(gain, nullptr);
    ASSERT_GE(gain->alternatives.size(), 2u);
    EXPECT_EQ(gain->alternatives[0].effect, "mass_error");
  }
}

TEST(TorqueMass, OfARealPendulumTheMassIsListedBesideTheGain) {
  const std::string path = find_shared("recordings/dfki_simple_pendulum/experiment.yaml");
  if (path.empty()) GTEST_SKIP() << "the recordings are not there, NOTHING was checked";
  const TorqueVerdict verdict = judge_torque(load_experiment(path), 1);
  const Finding* gain = find(verdict, "torque_constant_error", "shoulder");
  ASSERT_NE(gain, nullptr);
  EXPECT_TRUE(has_mass(*gain));
}

// Lowering a load takes less torque than its weight, lifting it does not: by the mean of both the arm looks too heavy.
TEST(TorqueMass, AGearThatTheLoadHardlyTurnsIsNamedWithItsLossAndIsNoWrongMass) {
  Hypothesis hidden;
  for (int joint : {kShoulder, kElbow}) {
    hidden.push_back({EffectId::kViscous, joint, {0.1}});
    hidden.push_back({EffectId::kCoulomb, joint, {0.1, 0.0, 5e-4}});
    hidden.push_back({EffectId::kRotorInertia, joint, {0.01}});
  }
  hidden.push_back({find_effect("backdriving_friction")->id, kElbow, {0.6, 5e-4}});
  const TorqueVerdict verdict = judge_torque(make_simulated_experiment("torque_gear", kArm, kArmJoints, hidden), 1);
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
  g.parameters = Eigen::VectorXd::Constant(1, value);
  g.std = g.width = Eigen::VectorXd::Constant(1, width);
  g.named = true;
  g.grade = Grade::kSupported;
  return g;
}

// A wrong mass with load-dependent friction and a gear that the load hardly turns take the same torque both ways.
TEST(TorqueMass, AWrongMassBesideFrictionOfTheLoadIsAGearThatLosesBackwards) {
  GradedTerm mass = make_graded(&TermRow::factor, 1, -0.46, 0.1),
             friction = make_graded(&TermRow::by_load, 0, 0.37, 0.1);
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
TEST(TorqueMass, HalfOfAMassBesideFrictionOfTheLoadIsReportedAsAGearThatLosesBackwards) {
  const Experiment e = make_simulated_experiment("torque_gears", kPendulum, {"hinge"}, {});
  const TorqueDesign design = make_torque_design(make_torque_data(e));
  // By the nominal load: lifting takes 0.54 + 0.37 of it, lowering 0.54 - 0.37.
  std::vector<GradedTerm> graded{make_graded(&TermRow::factor, 1, -0.46, 0.02),
                                 make_graded(&TermRow::by_load, 0, 0.37, 0.02)};
  explain_by_gears(design, &graded);
  EXPECT_EQ(graded[1].term.effect().name, "backdriving_friction");
  EXPECT_NEAR(graded[1].parameters[0], 1.0 - 0.17 / 0.91, 1e-12);
  EXPECT_EQ(graded[0].term.effect().name, "torque_constant_error");
  EXPECT_NEAR(1.0 - graded[0].parameters[0], 1.0 / 0.91, 1e-12);
  EXPECT_EQ(graded[0].grade, Grade::kAmbiguous);
}

TEST(TorqueMass, AMassThatIsATenthOffStaysAMassAndItsFrictionCountsTheTrueLoad) {
  const Experiment e = make_simulated_experiment("torque_gears", kPendulum, {"hinge"}, {});
  const TorqueDesign design = make_torque_design(make_torque_data(e));
  std::vector<GradedTerm> graded{make_graded(&TermRow::factor, 1, 0.1, 0.02),
                                 make_graded(&TermRow::by_load, 0, 0.11, 0.02)};
  explain_by_gears(design, &graded);
  EXPECT_EQ(graded[0].term.effect().name, "mass_error");
  EXPECT_NEAR(graded[1].parameters[0], 0.1, 1e-12);
}

// One link of nominal mass behind such a gear: slow motion cannot tell, but masses are weighed.
TEST(TorqueMass, OfARealServoLossesOfTheGearAreNamedAndNoWrongMass) {
  const std::string path = find_shared("recordings/bam_xl330_kp100/experiment.yaml");
  if (path.empty()) GTEST_SKIP() << "the recordings are not there, NOTHING was checked";
  const TorqueVerdict verdict = judge_torque(load_experiment(path), 1);
  EXPECT_EQ(find(verdict, "mass_error", "arm"), nullptr);
  EXPECT_NE(find(verdict, "load_dependent_friction", "servo"), nullptr);
}

// Level joints see a tilt of the base; the model of what was found is simulated with the gravity that the base sees.
TEST(TorqueMass, ATiltedBaseIsNamedAndItsModelHangsAlongTheTiltedGravity) {
  const EffectId tilt = find_effect("base_tilt")->id;
  const Hypothesis hidden{{tilt, 0, {0.0, 0.06}}};
  const Experiment e = make_simulated_experiment("torque_tilt", kArm, kArmJoints, hidden);
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

}  // namespace
}  // namespace hrp::diagnosis
