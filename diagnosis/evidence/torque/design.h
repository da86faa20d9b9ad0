// SPDX-License-Identifier: BSD-3-Clause
// The missing torque of every joint as a linear model of all terms. Sums are kept by fold: stretches of the training
// recordings, and each held-out recording.
#pragma once

#include <algorithm>
#include <memory>

#include "diagnosis/estimate/gram.h"
#include "diagnosis/measurement/torque/terms.h"

namespace hrp::diagnosis {

// Normal equations of one joint. Columns: the joint's terms, then those of the whole robot.
struct JointDesign {
  int joint = 0;
  std::vector<Term> terms;
  Columns first;                       // by term: its first column
  long own_width = 0;                  // columns of the joint's terms
  std::vector<const TermRow*> barred;  // rows whose terms may not be in any model of this joint
  std::vector<Gram> train, held;       // by fold; by held-out recording
  Gram total;                          // of `train`
  bool has_held = false;               // held-out recordings contain this joint; else `held` is a copy of `train`
  double spread = 0.0;                 // [N m] standard deviation of the effort, held-out recordings
  bool loaded = false;     // effort and nominal torque are correlated (> 0.8), alone or beside friction and rotor: a
                           // wrong gain shows
  double effective = 0.0;  // independent training samples, from the residual of the joint's terms without memory

  double weigh_squares() const { return 1.0 / std::max(1e-300, spread * spread); }  // [1/(N m)^2] to compare joints
};

// The linear models of all joints, with the terms of the whole robot.
struct TorqueDesign {
  std::shared_ptr<TorqueData> data;  // outliers and other rows that no term explains are marked as unused
  std::vector<Term> whole;
  Columns whole_first;              // by term: its first column after the joint's own columns
  std::vector<JointDesign> joints;  // that are judged and have enough samples
  bool has_held = false;            // of any joint
};

// Requires `data` with at least one recording.
TorqueDesign make_torque_design(TorqueData&& data);

// Columns of a joint's term, and of a term of the whole robot in a joint's rows.
Columns list_columns(const JointDesign& joint, size_t term);
Columns list_whole_columns(const TorqueDesign& design, const JointDesign& joint, size_t whole_term);

}  // namespace hrp::diagnosis
