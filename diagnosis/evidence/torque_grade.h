// SPDX-License-Identifier: BSD-3-Clause
// How far each term of the chosen model may be trusted (docs/report.md): how much of its joint's held-out mismatch it
// takes away, whether its value is the same in all stretches, and what would do as well in its place.
#pragma once

#include "diagnosis/findings/finding.h"
#include "diagnosis/evidence/torque_model.h"
#include "diagnosis/evidence/torque_stribeck.h"

namespace hrp::diagnosis {

// A term of a model: of a joint (index in the design), or of the whole robot (joint = -1); `at`: its place in the
// model's list.
struct TermPlace {
  int joint = -1;
  size_t at = 0;
};

// Another term that does as well in the place of a term.
struct Rival {
  Term term;
  Eigen::VectorXd parameters;
  Eigen::VectorXd width;  // standard deviation of each, as GradedTerm::width
  TorqueModel model;      // with it in the term's place; without terms where its values follow from the term's own
  TermPlace place;        // of it there
};

struct GradedTerm {
  Term term;
  TermPlace place;
  Eigen::VectorXd parameters, std;  // by column; std of the value that fits all recordings together
  Eigen::VectorXd width;            // standard deviation for intervals: also what parts of the recordings differ by
  DryCurve curve;                   // of a level of dry friction: what excess at rest it may have
  double probability = 1.0;         // that it is in the best model
  double gain = 0.0;    // [nats] that the model loses without it
  double share = 0.0;   // of its joint's held-out mismatch (Shapley), of the whole robot's: of all joints' together
  double weight = 0.0;  // of the whole mismatch
  std::vector<double> joint_share, joint_weight;  // of the whole robot's: the same by joint of the design
  double agreement = 0.0;  // share of stretches that give its first parameter the same sign
  bool helps_held = true;  // held-out recordings together are predicted worse without it
  bool harms_one = false;  // of them is predicted worse with it
  std::vector<Rival> rivals;
  bool named = false;      // else it only helps to predict
  Grade grade = Grade::kAmbiguous;
};

std::vector<GradedTerm> grade_terms(const TorqueDesign& design, const Choice& choice, int jobs);
// One of them.
GradedTerm grade_term(const TorqueDesign& design, const Choice& choice, const TermPlace& place);

// By joint: mean square of the missing torque on held-out recordings, nothing added.
double calc_nominal_held(const JointDesign& joint);

}  // namespace hrp::diagnosis
