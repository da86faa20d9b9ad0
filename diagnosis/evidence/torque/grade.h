// SPDX-License-Identifier: BSD-3-Clause
// Grades each term of the chosen model (docs/report.md). Three questions: which part of the joint's held-out mismatch
// it removes, whether all stretches give the same value, and which other terms fit equally well in its place.
#pragma once

#include <string>

#include "diagnosis/evidence/torque/model.h"
#include "diagnosis/evidence/torque/stribeck.h"
#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis {

// Place of a term in a model: joint (index in the design; -1: whole robot) and index `at` in the model's list.
struct TermPlace {
  int joint = -1;
  size_t at = 0;
};

bool is_same_family(const Term& a, const Term& b);

// Another term that fits equally well in the place of a term.
struct Rival {
  Term term;
  Eigen::VectorXd parameters;
  Eigen::VectorXd width;  // standard deviations, as GradedTerm::width
  TorqueModel model;      // with the rival in the term's place; empty if the rival's values follow from the term's
  TermPlace place;        // of the rival in `model`
};

// A term of the model with its value, its uncertainty and the results of all tests.
struct GradedTerm {
  Term term;
  TermPlace place;
  Eigen::VectorXd parameters, std;  // by column; std of the value common to all recordings
  Eigen::VectorXd width;     // standard deviation for intervals: contains differences between parts of the recordings
  DryCurve curve;            // for a level of dry friction: profile of its excess at rest
  double probability = 1.0;  // that its family is in the best model
  double gain = 0.0;         // [nats] that the model loses without it
  double share = 0.0;        // of its joint's held-out mismatch (Shapley); whole robot: the largest share of a joint
  double weight = 0.0;       // of the mismatch of all joints
  std::vector<double> joint_share, joint_weight;  // for terms of the whole robot: the same by joint of the design
  double agreement = 0.0;  // share of stretches that give it the same sign, with its parameters in proportion
  bool helps_held = true;  // without it, the held-out prediction of all recordings is worse
  bool rescales = false;   // a gain without which all others leave twice as much (root mean square, held out)
  bool harms_one = false;  // with it, the prediction of one held-out recording is more than 5 % worse
  std::vector<Rival> rivals;
  bool disagrees = false;  // stretches give it opposite signs
  bool unsized = false;    // parts of the recordings differ by more than its value
  bool named = false;      // if false, it only improves the prediction
  Grade grade = Grade::kAmbiguous;
  const char* doubt = "";  // why it is not supported, if that is not its rivals
  int balanced = -1;       // joint that alone shows a force along gravity, as a spring or a counterweight there would
  std::string instead;     // a law outside the list that does better in its place
};

// Grades all terms of the chosen model: those of joints first, then those of the whole robot.
std::vector<GradedTerm> grade_terms(const TorqueDesign& design, const Choice& choice, int jobs);
// Grades a single term.
GradedTerm grade_term(const TorqueDesign& design, const Choice& choice, const TermPlace& place);

// Mean square [(N m)^2] of the missing torque on held-out recordings, without any term.
double calc_nominal_held(const JointDesign& joint);

}  // namespace hrp::diagnosis
