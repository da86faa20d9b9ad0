// SPDX-License-Identifier: BSD-3-Clause
// The model that a user gets: positions and efforts count alike in its fit and in its choice.
#include <gtest/gtest.h>

#include "diagnosis/evidence/best_model.h"
#include "diagnosis/evidence/effort_rows.h"
#include "diagnosis/evidence/plain_model.h"
#include "diagnosis/evidence/polish.h"
#include "diagnosis/evidence/torque_findings.h"
#include "diagnosis/measurement/torque_residual.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

const std::vector<std::string> kJoints{"shoulder", "elbow"};

Hypothesis make_drives() {
  return {{EffectId::kViscous, kShoulder, {0.8}}, {EffectId::kCoulomb, kShoulder, {1.5, 0.0, 5e-4}},
          {EffectId::kRotorInertia, kShoulder, {0.6}}, {EffectId::kViscous, kElbow, {0.4}},
          {EffectId::kLoadFriction, kElbow, {0.2, 5e-4}}, {EffectId::kRotorInertia, kElbow, {0.3}}};
}

TEST(EffortRows, CountAsMuchAsTheSimulationWhereAFitStarts) {
  const Experiment e = make_simulated_experiment("effort_rows", kArm, kJoints, make_drives());
  const Problem problem = make_problem(e, 1);
  const TorqueData data = make_torque_data(e);
  const EffortRows rows(e, data);
  const CalcResiduals simulated = make_residuals(problem);
  const Hypothesis start = make_plain_model(fit_plain_model(problem));
  const double alone = calc_score(simulated, 1, start, problem.train).chi2,
               both = calc_score(rows.add_to(simulated, problem.train, start), 1, start, problem.train).chi2;
  EXPECT_NEAR(both, 2.0 * alone, 1e-9 * alone);  // rounding of the sums
}

// Friction of the elbow grows with its load, which plain least squares does not have.
TEST(BestModel, LeavesALesserProductOfHeldOutErrorsInRadAndInNewtonMetresThanPlainLeastSquares) {
  const Experiment e = make_simulated_experiment("best_model", kArm, kJoints, make_drives());
  const Problem problem = make_problem(e, 1);
  const TorqueVerdict verdict = judge_torque(e, 1);
  const Trial best = choose_best_model(problem, problem, verdict.model, {}, [](const std::string&) {});
  const Trial plain = simulate_trial(problem, make_plain_model(fit_plain_model(problem)));
  const TorqueData data = make_torque_data(e);
  const std::vector<double> efforts = calc_torque_residuals(data, make_plant(e, best.hypothesis), true),
                            plain_efforts = calc_torque_residuals(data, make_plant(e, plain.hypothesis), true);
  ASSERT_TRUE(best.validate.ok);
  const size_t elbow = kElbow * kQuantities;
  EXPECT_LT(best.validate.rms(elbow) * efforts[kElbow], plain.validate.rms(elbow) * plain_efforts[kElbow]);
}

// What a search found beside the drives is no part of the missing torque's model, and is not lost.
TEST(BestModel, KeepsASpringThatASearchFoundBesideFrictionAndRotors) {
  Hypothesis hidden = make_drives();
  const Effect spring{EffectId::kSpring, kShoulder, {40.0, 0.3}};
  hidden.push_back(spring);
  const Experiment e = make_simulated_experiment("best_searched", kArm, kJoints, hidden);
  const Problem problem = make_problem(e, 1);
  const Trial without = simulate_trial(problem, make_drives()),
              with = choose_best_model(problem, problem, make_drives(), {spring}, [](const std::string&) {});
  EXPECT_TRUE(contains(with.hypothesis, spring.id, spring.place));
  EXPECT_TRUE(contains(with.hypothesis, EffectId::kRotorInertia, at_joint(kShoulder)));
  EXPECT_LT(with.validate.rms(), 0.5 * without.validate.rms());  // the spring is a third of the shoulder's torque
}

// It fits best, because it is what was simulated, but no arm of 0.3 m is like that: it stands in for something else.
TEST(BestModel, HasNoCentreOfMassBeyondItsLink) {
  Hypothesis hidden = make_drives();
  const Effect far{EffectId::kComError, kFore, {1.2, 0.0, 0.0}};
  hidden.push_back(far);
  const Experiment e = make_simulated_experiment("best_possible", kArm, kJoints, hidden);
  const Problem problem = make_problem(e, 1);
  const Trial best = choose_best_model(problem, problem, make_drives(), {far}, [](const std::string&) {});
  EXPECT_FALSE(contains(best.hypothesis, far.id, far.place));
}

// Of the true model windows leave noise: the start states are recorded ones.
TEST(WindowResiduals, OfTheTrueModelAreAHundredthOfNominalOnes) {
  Experiment e = make_simulated_experiment("window_residuals", kArm, kJoints, make_drives());
  e.scenario.drive = "effort";
  const Problem problem = make_problem(e, 1);
  const CalcResiduals windows = make_window_residuals(problem);
  const double nominal = calc_score(windows, 1, {}, problem.train).chi2, right = calc_score(windows, 1, make_drives(), problem.train).chi2;
  EXPECT_LT(right, 1e-4 * nominal);  // squares: recorded states have an encoder's noise only
}

}  // namespace
}  // namespace hrp::diagnosis
