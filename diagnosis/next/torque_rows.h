// SPDX-License-Identifier: BSD-3-Clause
// Information of a motion about terms of the missing torque. These are linear, so the motion need not be simulated once
// more for each explanation.
#pragma once

#include <vector>

#include "diagnosis/next/information.h"
#include "diagnosis/next/open_terms.h"

namespace hrp::diagnosis {

// One motion, by joint of the design. Columns: those of TorqueRows::columns(joint).
struct MotionRows {
  std::vector<Eigen::MatrixXd> x;        // kept samples x columns; rows in which the joint rests are zero
  std::vector<Eigen::VectorXd> nominal;  // [N m] effort of the nominal model, kept samples
  std::vector<double> time;              // [s] of kept samples
  double step = 0.0;                     // [s] between them
};

class TorqueRows {
 public:
  explicit TorqueRows(const OpenTerms& terms);

  const Columns& columns(size_t joint) const { return columns_[joint]; }

  // Columns along the only recording of an experiment; false if it moves no judged joint.
  bool measure(const Experiment& motion, MotionRows* rows) const;

  // Predicted effort [N m] of a joint along the motion, kept samples.
  Eigen::VectorXd predict(const MotionRows& rows, const TorqueSide& side, size_t joint) const;
  // The same with half the width of its 95 % range, all values at their least favourable ends at once.
  Eigen::VectorXd calc_range(const MotionRows& rows, const TorqueSide& side, size_t joint) const;

  // Difference of the rival from the truth. Its unit is what the report's model leaves: it counts independent samples,
  // as many in a second as the recordings have.
  Comparison compare(const MotionRows& rows, const TorqueSide& truth, const TorqueSide& rival) const;
  std::vector<long> list_slots_of(const TorqueSide& side, size_t joint) const;  // by column; -1: not in the model
  // [s] of one training sample of a joint.
  double calc_sample_time(size_t joint) const;
  // Information of the recordings about the parameters of a side.
  Eigen::MatrixXd calc_known(const TorqueSide& side) const;

 private:
  Eigen::VectorXd list_coefficients(const TorqueSide& side, size_t joint) const;

  const OpenTerms& terms_;
  std::vector<std::vector<size_t>> own_;  // by joint: terms of any side
  std::vector<size_t> whole_;
  std::vector<Columns> columns_;    // by joint: in the design
  std::vector<double> per_second_;  // [1/s] by joint: independent samples
  std::vector<double> left_;        // [(N m)^2] by joint: mean square that the report's model leaves
};

}  // namespace hrp::diagnosis
