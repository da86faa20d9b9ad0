// SPDX-License-Identifier: BSD-3-Clause
// The missing torque of every joint as a linear model of all terms, summed by folds: stretches of the training
// recordings, and the recordings that nothing is fitted to.
#pragma once

#include <algorithm>
#include <memory>

#include "diagnosis/estimate/gram.h"
#include "diagnosis/measurement/torque_terms.h"

namespace hrp::diagnosis {

// Rows of one joint. Columns: terms of the joint, then those of the whole robot.
struct JointDesign {
  int joint = 0;
  std::vector<Term> terms;
  Columns first;        // by term: its first column
  long own_width = 0;   // columns of the joint's terms
  std::vector<const TermRow*> barred;  // whose terms are in no model
  std::vector<Gram> train, held;  // by fold; by held-out recording
  Gram total;                     // of `train`
  bool has_held = false;          // held-out recordings show it; else `held` is the training data
  double spread = 0.0;            // [N m] standard deviation of the effort, held-out recordings
  bool loaded = false;            // the effort is mostly what the nominal motion takes: its gain shows
  double effective = 0.0;         // samples of training that are independent, from what all terms together leave

  double weigh_squares() const { return 1.0 / std::max(1e-300, spread * spread); }  // [1/(N m)^2] to compare joints
};

struct TorqueDesign {
  std::shared_ptr<TorqueData> data;  // rows that no term comes near are taken out of use
  std::vector<Term> whole;
  Columns whole_first;               // by term: its first column after a joint's own
  std::vector<JointDesign> joints;   // of those that are judged and move
  bool has_held = false;             // of any joint
};

// `data` must have recordings.
TorqueDesign make_torque_design(TorqueData&& data);

// Columns of a joint's term, and of a term of the whole robot in a joint's rows.
Columns list_columns(const JointDesign& joint, size_t term);
Columns list_whole_columns(const TorqueDesign& design, const JointDesign& joint, size_t whole_term);

}  // namespace hrp::diagnosis
