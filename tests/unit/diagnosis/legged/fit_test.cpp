// SPDX-License-Identifier: BSD-3-Clause
// The weighted fit of effects over all equations: gains, noise, columns, laws.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "diagnosis/floating/fit/least_squares.h"
#include "diagnosis/floating/fit/remaining.h"
#include "diagnosis/floating/log/contacts.h"
#include "diagnosis/floating/report/check_findings.h"
#include "diagnosis/floating/report/words.h"
#include "tests/unit/diagnosis/legged/biped.h"
#include "tests/unit/diagnosis/legged/rows.h"

namespace hrp::diagnosis::floating {
namespace {

double calc_all_gain(const LeggedFitter& fitter, const LeggedFit& without, const LeggedFit& with) {
  return fitter.calc_gain(Part::kTrain, without, with) + fitter.calc_gain(Part::kHeld, without, with);
}

// I = I_cm + m (c.c 1 - c c^T) by the parallel axes; the columns about the middle of the way give all of its change.
TEST(LeggedColumns, InertiaOfAMassThatLiesElsewhereIsExact) {
  const Experiment e = make_biped({});
  const LeggedLog log = make_legged_log(e, Half::kEven);
  const ColumnLayout at(log);
  const std::vector<Candidate> all = list_candidates(log, at);
  const auto moved = std::find_if(all.begin(), all.end(), [](const Candidate& c) {
    return c.law == &get_laws().com_error && c.where.at("link") == "l_thigh";
  });
  ASSERT_NE(moved, all.end());
  const Vector3d d(0.02, -0.03, 0.05), c = moved->center;
  const Candidate exact = make_moved(*moved, at, d);
  const double mass = 4;
  const auto about = [&](const Vector3d& p) -> Matrix3d {
    return mass * (p.squaredNorm() * Matrix3d::Identity() - p * p.transpose());
  };
  const Matrix3d change = about(c + d) - about(c);
  double xx = 0, yz = 0;
  for (size_t i = 0; i < 3; ++i) {
    for (const auto& [column, factor] : exact.terms[i]) {
      if (column == at.link(moved->place, 4)) xx += factor * d(static_cast<long>(i));
      if (column == at.link(moved->place, 8)) yz += factor * d(static_cast<long>(i));
    }
  }
  EXPECT_NEAR(xx, change(0, 0), 1e-12);  // rounding
  EXPECT_NEAR(yz, change(1, 2), 1e-12);
}

// A lack that is the same all the time is one long error. Counted so, nothing that explains it would ever be worth its
// name.
TEST(LeggedFit, WhatLacksAllTheTimeCountsByTheErrorsThatItsCauseLeaves) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  RowHalves rows(1, 600, {{kWeight, {0}}});
  for (int i = 0; i < rows.cells(); ++i) {
    rows.add_cell(i, 1, [&](RowTable* half, double) {
      half->begin_row(0, 20 + 8 * normal(random), 400 + 40 * std::sin(0.1 * i));
      half->add(0, 0, 1.0);
    });
  }
  LeggedFitter fitter(rows.merge(), 1);
  const LeggedFit none = fitter.fit({}), with = fitter.fit({make_candidate(EffectId::kSensorBias, "", {{{0, 1.0}}})});
  EXPECT_LT(calc_all_gain(fitter, none, with), 60);    // 600 rows count as some 20
  EXPECT_GT(fitter.calc_gain_after(none, with), 300);  // they are 600: 600 log((20^2 + 8^2 / 2) / (8^2 / 2)) is 1500
}

// An equation that no effect changes has no products to sum.
TEST(LeggedFit, AnEquationWithoutColumnsKeepsItsMismatch) {
  RowHalves rows(1, 300, {{kWeight, {}}});
  for (int i = 0; i < rows.cells(); ++i) {
    rows.add_cell(i, 1, [](RowTable* half, double) { half->begin_row(0, 7, 400); });
  }
  const LeggedFitter fitter(rows.merge(), 1);
  EXPECT_DOUBLE_EQ(fitter.fit({}).mean_square[0][0], 49);
}

// Halves whose errors oppose each other differ by more than noise does: their difference overstates it. What explains
// the readings by halves is worth the same all the same.
TEST(LeggedFit, AnEffectBelowAnOverstatedNoiseStillGains) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  RowHalves rows(1, 600, {{make_joint_channel("A"), {0}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const double x = normal(random), opposed = 8 * normal(random), noise = 2 * normal(random);
    rows.add_cell(i, 1, [&](RowTable* half, double sign) {
      half->begin_row(0, 3 * x + noise + sign * opposed, 20);
      half->add(0, 0, x);
    });
  }
  LeggedFitter fitter(rows.merge(), 1);
  const LeggedFit none = fitter.fit({}),
                  with = fitter.fit({make_candidate(EffectId::kRotorInertia, "A", {{{0, 1.0}}})});
  EXPECT_EQ(none.mean_square[0][0], 0) << "3^2 + 2^2 - 8^2 is negative";
  EXPECT_NEAR(with.x(0), 3, 0.4);  // four errors of 2 / sqrt(600)
  // 600 log((9 + 64) / 64) over all rows is 79; half of them are fitted. Chance alone gains 1.
  EXPECT_GT(calc_all_gain(fitter, none, with), 40);
}

// A fit that no sums can tell says nothing of errors: the next fits weigh as before.
TEST(LeggedFit, AColumnThatIsNoiseAloneSpoilsNoOtherFit) {
  LeggedFitter fitter(make_calm_and_rough(), 2);
  const Candidate rotor = make_candidate(EffectId::kRotorInertia, "A", {{{0, 1.0}}});
  for (int round = 0; round < 4; ++round) fitter.update_weights(fitter.fit({rotor}));
  const LeggedFit noise = fitter.fit({make_candidate(EffectId::kViscous, "A", {{{1, 1.0}}})});
  ASSERT_FALSE(noise.x.allFinite()) << "1 - 3^2 is negative";
  fitter.update_weights(noise);
  EXPECT_NEAR(fitter.fit({rotor}).x(0), 100, 1);  // 1 %: errors of 1 in 450 swings of 1 are 0.05
}

// Weights settle in rounds, each with the columns of what was chosen alone: sums of all columns took nine tenths of the
// time. A fit by a few sums is that by all of them, and the last round has them all again.
TEST(LeggedFit, OfItsOwnColumnsAloneIsTheSameFit) {
  LeggedFitter few(make_calm_and_rough(), 2), all(make_calm_and_rough(), 2);
  const Candidate rotor = make_candidate(EffectId::kRotorInertia, "A", {{{0, 1.0}}});
  const std::vector<int> own{0};
  few.update_weights(few.fit({rotor}), &own);
  all.update_weights(all.fit({rotor}));
  EXPECT_DOUBLE_EQ(few.fit({rotor}).x(0), all.fit({rotor}).x(0));
  EXPECT_DOUBLE_EQ(few.fit({rotor}).mean_square[1][0], all.fit({rotor}).mean_square[1][0]);
  EXPECT_DOUBLE_EQ(few.fit({}).mean_square[0][0], all.fit({}).mean_square[0][0]);
  few.update_weights(few.fit({rotor}));
  all.update_weights(all.fit({rotor}));
  EXPECT_DOUBLE_EQ(few.calc_ceiling(0), all.calc_ceiling(0));
}

// Frictions of two joints are in no equation together: no single effect is tried in the place of both.
TEST(LeggedFit, EffectsHaveACommonEquationWhereBothChangeIt) {
  RowHalves rows(3, 60, {{make_joint_channel("A"), {0, 2}}, {make_joint_channel("B"), {1, 2}}});
  for (int i = 0; i < rows.cells(); ++i) {
    rows.add_cell(i, 1, [](RowTable* half, double) {
      half->begin_row(0, 1, 20);
      half->begin_row(1, 1, 20);
    });
  }
  const LeggedFitter fitter(rows.merge(), 3);
  const Candidate a = make_candidate(EffectId::kCoulomb, "A", {{{0, 1.0}}}),
                  b = make_candidate(EffectId::kCoulomb, "B", {{{1, 1.0}}});
  const Candidate mass = make_candidate(EffectId::kMassError, "C", {{{2, 1.0}}});
  EXPECT_FALSE(fitter.have_common_equation(a, b));
  EXPECT_TRUE(fitter.have_common_equation(a, mass));
  EXPECT_TRUE(fitter.have_common_equation(b, mass));
}

// How much of what play predicts give predicts, too, by torques of one size or of all sizes up to the largest.
double calc_overlap_of_play_and_give(bool one_size) {
  std::mt19937 random(17);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> spread(0, 1);
  RowHalves rows(2, 3000, {{{{EquationKind::kTilt, 0}, "/joint_states", "rad", "foot", "A"}, {0, 1}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const double torque = one_size ? 1 : spread(random);
    rows.add_cell(i, 1, [&](RowTable* half, double) {
      half->begin_row(0, 0, 1);
      half->add(0, 0, 0.5);
      half->add(0, 1, torque + normal(random));
    });
  }
  const LeggedFitter fitter(rows.merge(), 2);
  return fitter.calc_overlap(make_candidate(EffectId::kBacklash, "A", {{{0, 1.0}}}),
                             make_candidate(EffectId::kElasticity, "A", {{{1, 1.0}}}));
}

// Play moves a link by the sign of its torque, give in proportion to it. Over torques that are spread evenly up to
// their largest, (E |T|)^2 / E T^2 = (1/2)^2 / (1/3); over torques of one size nothing is left to tell them apart.
TEST(LeggedFit, PlayAndGiveAreAsAlikeAsTorquesAreOfOneSize) {
  // Noise of 1 in 3000 rows leaves 2 / sqrt(3000) of a square of 1/3: a tenth.
  EXPECT_NEAR(calc_overlap_of_play_and_give(false), 0.75, 0.1);
  EXPECT_NEAR(calc_overlap_of_play_and_give(true), 1.0, 0.1);
}

TEST(LeggedLaws, AGiveThatMayBeNoneHasNoStiffness) {
  const Eigen::VectorXd x = Eigen::VectorXd::Constant(1, 4e-5), sure = 0.1 * x, unsure = 0.6 * x;
  const CandidateLaw& give = get_laws().elasticity;
  ASSERT_EQ(give.make_estimates({}, x, sure).size(), 1u);
  EXPECT_DOUBLE_EQ(give.make_estimates({}, x, sure)[0].value[0], 25000);
  EXPECT_TRUE(give.make_estimates({}, x, unsure).empty()) << "4e-5 +- 4.7e-5 rad/(N m), two deviations";
}

// Two joints whose errors change from row to row, so that neither stands out: of this size [N m], and noise of which
// half comes back with the other sign, so that products of the halves lack 0.5 N^2 m^2. `signal`: what is measured [N
// m].
std::vector<Remaining> list_remaining_of_noise(const std::vector<size_t>& unsteady, double size, double signal = 20) {
  std::mt19937 random(29);
  std::normal_distribution<double> normal;
  RowHalves rows(1, 900, {{make_joint_channel("A"), {}}, {make_joint_channel("B"), {}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const double errors[] = {size * normal(random), size * normal(random)},
                 opposed[] = {normal(random), normal(random)};
    rows.add_cell(i, 1, [&](RowTable* half, double sign) {
      for (int c = 0; c < 2; ++c) half->begin_row(c, errors[c] + (sign > 0 ? 1 : -0.5) * opposed[c], signal);
    });
  }
  const LeggedFitter fitter(rows.merge(), 1);
  const LeggedFit nominal = fitter.fit({});
  return list_remaining(fitter, nominal, nominal, unsteady);
}

// A verdict that stands on an effect that was not of one size says where that was.
TEST(LeggedRemaining, AnEquationThatAnEffectOfManySizesHelpedIsListedWithItsPlace) {
  EXPECT_TRUE(list_remaining_of_noise({}, 1).empty());
  const std::vector<Remaining> left = list_remaining_of_noise({1, 1}, 1);
  ASSERT_EQ(left.size(), 1u);
  EXPECT_EQ(left[0].where.at("joint"), "B");
  EXPECT_NEAR(left[0].before, std::sqrt(0.5), 0.1);  // 1 - 0.5; four errors of 1.4 / sqrt(300) of the square
  EXPECT_DOUBLE_EQ(left[0].after, left[0].before);
}

// No column predicts it and it does not last, as in a recording of a second; but nothing of the signal is predicted.
TEST(LeggedRemaining, AnEquationThatLeavesAsMuchAsItsSignalIsListed) {
  EXPECT_TRUE(list_remaining_of_noise({}, 6, 20).empty());
  EXPECT_EQ(list_remaining_of_noise({}, 6, 6).size(), 2u);
}

// 13 N that one column explains, but for `left` [N].
size_t count_left_of_explained(double left) {
  std::mt19937 random(31);
  std::normal_distribution<double> normal;
  RowHalves rows(1, 900, {{make_joint_channel("A"), {0}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const double cause = normal(random), other = left * normal(random);
    rows.add_cell(i, 1, [&](RowTable* half, double) {
      half->begin_row(0, 13 * cause + other + 0.01 * normal(random), 40 * std::sin(0.1 * i));
      half->add(0, 0, cause);
    });
  }
  const LeggedFitter fitter(rows.merge(), 1);
  return list_remaining(fitter, fitter.fit({}), fitter.fit({make_candidate(EffectId::kViscous, "A", {{{0, 1.0}}})}), {})
      .size();
}

// Models are exact to 0.5 % of a signal's spread: 0.14 N of 28.
TEST(LeggedRemaining, WhatIsExplainedToWhatModelsAreExactToIsNotListed) {
  EXPECT_EQ(count_left_of_explained(0), 0u);
  EXPECT_EQ(count_left_of_explained(0.3), 1u);
}

TEST(LeggedRemaining, AnEquationThatHasNothingBeyondNoiseByNowIsListedWithItsNoise) {
  const std::vector<Remaining> left = list_remaining_of_noise({1}, 0);
  ASSERT_EQ(left.size(), 1u);
  EXPECT_NEAR(left[0].before, 0.25, 0.03);  // the mean of both halves
  EXPECT_DOUBLE_EQ(left[0].share(), 1);
}

// What a report says when a search of a biped's log has ended with `found`, after checks.
std::vector<Finding> report_checks(const LeggedFitter& fitter, const LeggedOutcome& outcome, const CheckResult& checks,
                                   const std::vector<Finding>& found) {
  const LeggedLog log = make_legged_log(make_biped({}), Half::kEven);
  const Contacts contacts = find_contacts(log);
  const std::vector<SoleLaw> soles;
  ReportState state{log, contacts, fitter, outcome, soles, fitter.fit({}), {}};
  state.evidence.findings = found;
  add_check_findings(checks, &state);
  return state.evidence.findings;
}

// Feet carry 100 N too much half of the time, of which a free law predicts `share`. How many findings say it is a mass.
size_t count_masses(double share) {
  RowHalves rows(1, 900, {{kWeight, {0}}});
  for (int i = 0; i < rows.cells(); ++i) {
    const double held = i % 40 < 20 ? 100 : 0;
    rows.add_cell(i, 1, [&](RowTable* half, double) {
      half->begin_row(0, held, 400);
      half->add(0, 0, share * held);
    });
  }
  const LeggedFitter fitter(rows.merge(), 1);
  Candidate hold = make_candidate(EffectId::kNamed, "A", {{{0, 1.0}}});
  hold.law = &get_laws().hold;
  LeggedOutcome outcome{fitter.fit({}), fitter.fit({hold}), {}, {}};
  outcome.chosen.x(0) = 1;
  for (auto& part : outcome.chosen.mean_square) part[0] = std::pow(100 * (1 - share), 2) / 2;
  outcome.effects.emplace_back();
  outcome.effects[0].effect = hold;
  CheckResult checks;
  checks.findings = {make_finding(get_laws().payload.info(), {{"link", "pelvis"}}, {})};
  return report_checks(fitter, outcome, checks, {}).size();
}

TEST(LeggedChecks, AWeightThatIsTooLargeBecauseSomethingHoldsTheFootIsNoMass) {
  EXPECT_EQ(count_masses(0.95), 0u);
  EXPECT_EQ(count_masses(0.1), 1u);
}

// A hip that bends lets feet that stand drift in height by the base's pose. The slope that a check makes of it is none.
TEST(LeggedChecks, WhatACheckCannotTellIsNoFindingWhereSomethingOutsideTheTableMoves) {
  RowHalves rows(1, 100, {{kWeight, {0}}});
  for (int i = 0; i < rows.cells(); ++i)
    rows.add_cell(i, 1, [&](RowTable* half, double) {
      half->begin_row(0, 10, 400);
      half->add(0, 0, 1);
    });
  const LeggedFitter fitter(rows.merge(), 1);
  CheckResult checks;
  checks.findings = {make_finding(get_laws().ground_slope.info(), {{"ground", "ground"}}, {})};
  checks.findings[0].grade = Grade::kAmbiguous;
  LeggedOutcome outcome{fitter.fit({}), fitter.fit({}), {}, {}};
  EXPECT_EQ(report_checks(fitter, outcome, checks, {}).size(), 1u);
  outcome.effects.emplace_back();
  outcome.effects[0].effect = make_candidate(EffectId::kNamed, "A", {{{0, 1.0}}});
  outcome.effects[0].effect.law = &get_laws().hold;
  EXPECT_TRUE(report_checks(fitter, outcome, checks, {}).empty());
}

TEST(LeggedWords, AnAxisThatNothingShowsIsUnknown) {
  const Estimate force{"force", "N", {10, 0, -20}, {1, 0, 2}, true};
  EXPECT_EQ(describe({force}), "force 10 +- 2, unknown, -20 +- 3.9 N");
}

// Vertical forces say where a weight is missing, and nothing of which link has it.
TEST(LeggedChecks, OfAWeightAloneTheReportNamesNoLinkAmongMany) {
  RowHalves rows(1, 100, {{kWeight, {0}}});
  for (int i = 0; i < rows.cells(); ++i)
    rows.add_cell(i, 1, [&](RowTable* half, double) {
      half->begin_row(0, 10, 400);
      half->add(0, 0, 1);
    });
  const LeggedFitter fitter(rows.merge(), 1);
  const LeggedOutcome outcome{fitter.fit({}), fitter.fit({}), {}, {}};
  Finding shin = make_finding(get_laws().mass_error.info(), {{"link", "l_shin"}}, {make_one("scale", "1", 2, 0.1)});
  shin.grade = Grade::kAmbiguous;
  shin.alternatives = {make_alternative(get_laws().mass_error.info(), {{"link", "r_shin"}}, {}, "")};
  CheckResult checks;
  checks.findings = {make_finding(get_laws().payload.info(), {{"link", "pelvis"}}, {make_one("mass", "kg", 1, 0.1)})};
  const std::vector<Finding> findings = report_checks(fitter, outcome, checks, {shin});
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].where.at("link"), "pelvis");
  ASSERT_FALSE(findings[0].alternatives.empty());
  EXPECT_EQ(findings[0].alternatives.back().where.at("link"), "l_shin") << "what the search named is kept";
}

// A foot's height by a capture of the base goes through the encoders of its leg.
TEST(LeggedChecks, HeightsThatDriftBesideAWrongZeroInThatLegAreNoSlope) {
  RowHalves rows(1, 100, {{kWeight, {0}}});
  rows.add_cell(0, 1, [&](RowTable* half, double) {
    half->begin_row(0, 1, 400);
    half->add(0, 0, 1);
  });
  const LeggedFitter fitter(rows.merge(), 1);
  const LeggedOutcome outcome{fitter.fit({}), fitter.fit({}), {}, {}};
  CheckResult checks;
  checks.findings = {
      make_finding(get_laws().ground_slope.info(), {{"ground", "ground"}}, {make_one("pitch", "rad", 0.003, 0.001)})};
  const Finding zero =
      make_finding(get_laws().joint_offset.info(), {{"joint", "l_hip"}}, {make_one("offset", "rad", -0.02, 0.001)});
  const Finding load = make_finding(get_laws().payload.info(), {{"link", "pelvis"}}, {make_one("mass", "kg", 1, 0.1)});
  EXPECT_EQ(report_checks(fitter, outcome, checks, {zero}).size(), 1u);
  EXPECT_EQ(report_checks(fitter, outcome, checks, {load}).size(), 2u);
}

Finding make_turned(double pitch, double roll_std) {
  return make_finding(get_laws().sensor_misalignment.info(), {{"sensor", "/imu/waist"}},
                      {{"rpy", "rad", {0, pitch, 0}, {roll_std, 0.003, 0.004}, true}});
}

// The search looks at recordings without what was corrected before: it sees the rest of a fault alone.
TEST(LeggedChecks, AFaultThatWasCorrectedBeforeTheSearchIsReportedWithAllOfItsSize) {
  RowHalves rows(1, 100, {{kWeight, {0}}});
  rows.add_cell(0, 1, [&](RowTable* half, double) {
    half->begin_row(0, 1, 400);
    half->add(0, 0, 1);
  });
  const LeggedFitter fitter(rows.merge(), 1);
  const LeggedOutcome outcome{fitter.fit({}), fitter.fit({}), {}, {}};
  Finding rest = make_turned(0.005, 0.001);
  rest.grade = Grade::kAmbiguous;
  CheckResult checks;
  checks.corrected = {make_turned(0.035, 0.001)};
  const std::vector<Finding> findings = report_checks(fitter, outcome, checks, {rest});
  ASSERT_EQ(findings.size(), 1u);
  const Finding& f = findings[0];
  EXPECT_NEAR(f.parameters[0].value[1], 0.04, 1e-9);
  EXPECT_NEAR(f.parameters[0].std[0], 0.001 * std::sqrt(2), 1e-9);
  EXPECT_EQ(f.grade, Grade::kSupported);  // as the larger part is
}

}  // namespace
}  // namespace hrp::diagnosis::floating
