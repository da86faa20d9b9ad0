// SPDX-License-Identifier: BSD-3-Clause
// The model that a user gets: positions and efforts count alike in its fit and in its choice.
#include <gtest/gtest.h>

#include <algorithm>

#include "diagnosis/evidence/best_model.h"
#include "diagnosis/evidence/effort_rows.h"
#include "diagnosis/evidence/other_tools.h"
#include "diagnosis/evidence/plain_model.h"
#include "diagnosis/evidence/polish.h"
#include "diagnosis/evidence/torque/findings.h"
#include "diagnosis/measurement/torque/residual.h"
#include "tests/unit/diagnosis/simulated_experiment.h"

namespace hrp::diagnosis {
namespace {

const std::vector<std::string> kJoints{"shoulder", "elbow"};

Hypothesis make_drives() {
  return {{EffectId::kViscous, kShoulder, {0.8}},         {EffectId::kCoulomb, kShoulder, {1.5, 0.0, 5e-4}},
          {EffectId::kRotorInertia, kShoulder, {0.6}},    {EffectId::kViscous, kElbow, {0.4}},
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
  const Trial best =
      choose_best_model(problem, problem, verdict.model, verdict.evidence.explained, {}, [](const std::string&) {});
  const Trial plain = simulate_trial(problem, make_plain_model(fit_plain_model(problem)));
  const TorqueData data = make_torque_data(e);
  const std::vector<double> efforts = calc_torque_residuals(data, make_plant(e, best.hypothesis), true),
                            plain_efforts = calc_torque_residuals(data, make_plant(e, plain.hypothesis), true);
  ASSERT_TRUE(best.validate.ok);
  const size_t elbow = kElbow * kQuantities;
  EXPECT_LT(best.validate.rms(elbow) * efforts[kElbow], plain.validate.rms(elbow) * plain_efforts[kElbow]);
}

// Plain least squares and positions alone are ways to a model that the missing torque did not show.
TEST(BestModel, IsSoughtFromTheMissingTorqueAloneWhereThatIsExplainedButForATrace) {
  const Experiment e = make_simulated_experiment("best_settled", kArm, kJoints, make_drives());
  const Problem problem = make_problem(e, 1);
  std::string tried;
  const auto read = [&](const std::string& line) { tried += line + "\n"; };
  const Trial best = choose_best_model(problem, problem, make_drives(), 0.995, {}, read),
              given = simulate_trial(problem, make_drives());
  EXPECT_EQ(tried.find("least squares, fitted"), std::string::npos) << tried;
  EXPECT_EQ(tried.find("positions alone"), std::string::npos) << tried;
  EXPECT_NE(tried.find("fitted through each joint's simulation"), std::string::npos) << tried;
  EXPECT_LE(best.validate.rms(),
            1.01 * given.validate.rms());  // as good as the truth, within the blur of a fit to noise
}

// Friction that acts in the training recording alone, as of a cable that was taken off: whoever has no friction in the
// model is closer to the held-out one.
TEST(BestModel, IsTheNominalOneIfNothingFoundIsCloserToTheHeldOutRecordings) {
  const Experiment with = make_simulated_experiment("best_nominal_train", kArm, kJoints, make_drives());
  Experiment e = make_simulated_experiment("best_nominal", kArm, kJoints, {});
  for (size_t r = 0; r < e.recordings.size(); ++r) {
    if (e.recordings[r].spec.train) e.recordings[r] = with.recordings[r];
  }
  const Problem problem = make_problem(e, 1);
  EXPECT_TRUE(
      choose_best_model(problem, problem, make_drives(), 0.0, {}, [](const std::string&) {}).hypothesis.empty());
}

// A simulation takes its own steps between two samples: an arm of six joints at 125 Hz would otherwise be fitted for
// minutes.
TEST(BestModel, AFitThroughTheWholeRobotIsAsLongForALogOfFewSamplesAsForOneOfMany) {
  Experiment e = make_simulated_experiment("best_work", kArm, kJoints, {});
  const double all = calc_whole_work(make_problem(e, 1), make_drives(), 1);
  for (Recording& r : e.recordings) {
    const auto thin = [](std::vector<double>* column) {
      std::vector<double> out;
      for (size_t k = 0; k < column->size(); k += 4) out.push_back((*column)[k]);
      *column = out;
    };
    thin(&r.time);
    for (JointColumns& joint : r.joints) {
      for (std::vector<double>* column :
           {&joint.command, &joint.command_rate, &joint.signal[0], &joint.signal[1], &joint.signal[2]})
        thin(column);
    }
  }
  EXPECT_NEAR(calc_whole_work(make_problem(e, 1), make_drives(), 1), all, 0.01 * all);  // the last samples
}

// The elbow stands still but for the flicker of its encoder. Simulated from its effort, it drifts.
TEST(BestModel, IsNotChosenByWhereAJointAtRestDrifts) {
  Experiment e = make_simulated_experiment("best_rest", kArm, kJoints, make_drives());
  e.scenario.drive = "effort";
  for (Recording& r : e.recordings) {
    std::vector<double>& q = r.joints[kElbow].signal[0];
    for (size_t k = 0; k < r.size(); ++k) q[k] = 0.2 + (k % 2 == 0 ? 1e-7 : 0.0);
    const size_t most = r.size() / 4;  // for the time of the test
    r.time.resize(most);
    for (JointColumns& joint : r.joints) {
      for (std::vector<double>* column :
           {&joint.command, &joint.command_rate, &joint.signal[0], &joint.signal[1], &joint.signal[2]})
        column->resize(std::min(column->size(), most));
    }
  }
  const Problem problem = make_problem(e, 1);
  std::vector<double> missed;  // [%] of the spread of positions, by model
  const auto read = [&](const std::string& line) {
    const std::string words = "positions miss ";
    const size_t at = line.find(words);
    if (at != std::string::npos) missed.push_back(std::stod(line.substr(at + words.size())));
  };
  choose_best_model(problem, problem, make_drives(), 0.0, {}, read);
  ASSERT_FALSE(missed.empty());
  // The shoulder moves by more than it drifts in a window; the elbow's error is a million times its spread.
  EXPECT_LT(*std::max_element(missed.begin(), missed.end()), 1000.0);
}

// What a search found beside the drives is no part of the missing torque's model, and is not lost.
TEST(BestModel, KeepsASpringThatASearchFoundBesideFrictionAndRotors) {
  Hypothesis hidden = make_drives();
  const Effect spring{EffectId::kSpring, kShoulder, {40.0, 0.3}};
  hidden.push_back(spring);
  const Experiment e = make_simulated_experiment("best_searched", kArm, kJoints, hidden);
  const Problem problem = make_problem(e, 1);
  const Trial without = simulate_trial(problem, make_drives()),
              with = choose_best_model(problem, problem, make_drives(), 0.0, {spring}, [](const std::string&) {});
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
  const Trial best = choose_best_model(problem, problem, make_drives(), 0.0, {far}, [](const std::string&) {});
  EXPECT_FALSE(contains(best.hypothesis, far.id, far.place));
}

// Limits far below the efforts leave little torque to miss: relative to that of the log, such a model would seem to be
// good.
TEST(BestModel, HasNoDriveThatGivesAHundredthOfItsLoggedEffort) {
  const Experiment e = make_simulated_experiment("best_limit", kArm, kJoints, make_drives());
  EXPECT_NE(find_odd_effect(e, {{EffectId::kSaturation, kShoulder, {0.05}}}, {}), "");
  EXPECT_EQ(find_odd_effect(e, {{EffectId::kSaturation, kShoulder, {8.0}}}, {}), "");
}

// Models are compared by these: without it a model with the true hysteresis loses to one that has none.
TEST(TorqueResiduals, HaveFrictionWithMemoryAlongTheRecordedMotion) {
  Hypothesis hidden = make_drives();
  hidden.push_back({EffectId::kHysteresis, kElbow, {100.0, 0.04}});
  const Experiment e = make_simulated_experiment("residual_memory", kArm, kJoints, hidden);
  const TorqueData data = make_torque_data(e);
  const std::vector<double> with = calc_torque_residuals(data, make_plant(e, hidden), true),
                            without = calc_torque_residuals(data, make_plant(e, make_drives()), true);
  EXPECT_LT(with[kElbow], 0.2 * without[kElbow]);  // the filter takes what changes fastest, at reversals
}

// Friction that slips at once: the usual displacement of 0.5 mrad would let the arm creep at every reversal.
TEST(FindPreslidings, OfFrictionThatSlipsAtOnceAreAMatterOfMicroradians) {
  Hypothesis hidden = make_drives();
  hidden[1].p[2] = 3e-6;
  hidden[4].p[1] = 3e-6;
  const Experiment e = make_simulated_experiment("preslidings", kArm, kJoints, hidden);
  const Problem problem = make_problem(e, 1);
  const Hypothesis found = find_preslidings(problem, make_drives());
  EXPECT_LE(found[1].p[2], 3e-5);  // an encoder's step: below it nothing shows
  EXPECT_LE(found[4].p[1], 3e-5);
  EXPECT_EQ(found[1].p[0], make_drives()[1].p[0]);
  EXPECT_LT(simulate_trial(problem, found).rms, 0.5 * simulate_trial(problem, make_drives()).rms);
}

// The log reads 0.4 N m over the position, and nothing acts on the joint.
TEST(DropRipples, OfALogAreNoTorqueOnTheJoint) {
  const Effect ripple{EffectId::kCogging, kElbow, {0.4, 20.0, 0.3}};
  Experiment e = make_simulated_experiment("log_ripple", kArm, kJoints, make_drives());
  for (Recording& r : e.recordings) {
    JointColumns& elbow = r.joints[kElbow];
    for (size_t k = 0; k < r.size(); ++k) elbow.signal[2][k] -= 0.4 * std::sin(20.0 * elbow.signal[0][k] + 0.3);
  }
  Hypothesis model = make_drives();
  model.push_back(ripple);
  const Problem problem = make_problem(e, 1);
  EXPECT_FALSE(contains(drop_ripples_of_logs(problem, model), ripple.id, ripple.place));
  EXPECT_FALSE(contains(choose_best_model(problem, problem, model, 0.0, {}, [](const std::string&) {}).hypothesis,
                        ripple.id, ripple.place));
}

TEST(DropRipples, ThatMoveTheJointStay) {
  const Effect ripple{EffectId::kCogging, kElbow, {0.4, 20.0, 0.3}};
  Hypothesis hidden = make_drives();
  hidden.push_back(ripple);
  const Experiment e = make_simulated_experiment("joint_ripple", kArm, kJoints, hidden);
  EXPECT_TRUE(contains(drop_ripples_of_logs(make_problem(e, 1), hidden), ripple.id, ripple.place));
}

TEST(RicherLaws, HaveTheLateLogOfAnEffort) {
  Hypothesis hidden = make_drives();
  const Place log = at_sensor(kElbow, Reading::kEffort);
  hidden.push_back({EffectId::kSensorDelay, log, {0.02}});
  const Experiment e = make_simulated_experiment("richer_log", kArm, kJoints, hidden);
  const Hypothesis found = polish_joints(make_problem(e, 1), make_drives(), nullptr, true);
  const auto late = std::find_if(found.begin(), found.end(), [&](const Effect& effect) {
    return effect.id == EffectId::kSensorDelay && effect.place == log;
  });
  ASSERT_NE(late, found.end());
  EXPECT_NEAR(late->p[0], 0.02, 0.001);  // a fifth of the sampling time
}

TEST(RicherLaws, HaveAllParametersOfFrictionThatGrowsWithLoad) {
  const Experiment e = make_simulated_experiment("richer_load", kArm, kJoints, make_drives());
  Hypothesis model = make_drives();
  model[4] = {EffectId::kCoulomb, kElbow, {0.5, 0.0, 5e-4}};  // the elbow's friction grows with its load
  for (const Effect& effect : polish_joints(make_problem(e, 1), model, nullptr, true))
    EXPECT_EQ(effect.p.size(), list_infos(effect.id).size()) << get_effect(effect.id).name;
}

// Of the true model windows leave noise: the start states are recorded ones.
TEST(WindowResiduals, OfTheTrueModelAreAHundredthOfNominalOnes) {
  Experiment e = make_simulated_experiment("window_residuals", kArm, kJoints, make_drives());
  e.scenario.drive = "effort";
  const Problem problem = make_problem(e, 1);
  const CalcResiduals windows = make_window_residuals(problem);
  const double nominal = calc_score(windows, 1, {}, problem.train).chi2,
               right = calc_score(windows, 1, make_drives(), problem.train).chi2;
  EXPECT_LT(right, 1e-4 * nominal);  // squares: recorded states have an encoder's noise only
}

// Friction of the elbow that grows with its load is a part of BAM's third model, and not of its first, which is also
// all that damping, friction loss and armature of a simulator can say.
TEST(OtherTools, AFrictionModelWithTheLoadPredictsTheMotionOfADriveWithSuchFrictionBestOfThoseOfItsSize) {
  const Experiment e = make_simulated_experiment("other_tools", kArm, kJoints, make_drives());
  const Problem problem = make_problem(e, 1);
  const std::vector<OtherAnswer> answers = fit_friction_models(problem);
  ASSERT_EQ(answers.size(), 5u);
  const auto judge = [&](size_t i) {
    return calc_score(problem, answers[i].hypothesis, problem.validate).rms(kElbow * kQuantities);
  };
  EXPECT_LT(judge(2), 0.5 * judge(0)) << "half: the load takes most of this elbow's friction";
  const auto load = std::find_if(answers[2].hypothesis.begin(), answers[2].hypothesis.end(), [](const Effect& effect) {
    return effect.id == EffectId::kLoadFriction && effect.place.index == kElbow;
  });
  ASSERT_NE(load, answers[2].hypothesis.end());
  EXPECT_NEAR(load->p[0], 0.2, 0.04);  // a fifth: the model also has a constant level, which this elbow has not
}

}  // namespace
}  // namespace hrp::diagnosis
