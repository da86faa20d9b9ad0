// SPDX-License-Identifier: BSD-3-Clause
// Intervals to expect of the report's values after one more motion.
#pragma once

#include <utility>
#include <vector>

#include "diagnosis/evidence/torque/intervals.h"
#include "diagnosis/next/propose.h"
#include "diagnosis/next/torque_rows.h"

namespace hrp::diagnosis {

// Lowest and highest position of each joint [rad or m].
using Ranges = std::vector<std::pair<double, double>>;
void widen(const std::vector<double>& positions, std::pair<double, double>* range);

// What motions add to the recordings.
struct Gained {
  Eigen::MatrixXd fisher;                  // about the report's model
  Ranges ranges;                           // of joints, recordings included
  std::vector<ConsideredSums> considered;  // by joint of the design
};

class ExpectedIntervals {
 public:
  // All arguments must outlive this object.
  ExpectedIntervals(const Experiment& experiment, const OpenTerms& terms, const TorqueRows& rows, const Limits& limits);

  // Nothing beyond the recordings.
  const Gained& nothing() const { return nothing_; }
  std::vector<ConsideredSums> sum_along(const MotionRows& motion) const;  // by joint of the design
  // Lowers ExpectedInterval::least to what a motion would reach if it were repeated for ever.
  void allow(const std::vector<ConsideredSums>& along);
  std::vector<ExpectedInterval> list(const Gained& gained) const;

 private:
  std::vector<double> list_considered(const std::vector<ConsideredSums>& gained,
                                      double times) const;  // half width by slot of the report's model

  const Experiment& e_;
  const OpenTerms& terms_;
  const TorqueRows& rows_;
  Eigen::MatrixXd known_;
  std::vector<std::vector<long>> slots_;  // by joint of the design: slots of its columns
  std::vector<ConsideredSums> sums_;      // the same, of the recordings
  Gained nothing_;
  Eigen::VectorXd before_;           // standard deviation by slot, from the recordings alone
  std::vector<double> now_, least_;  // list_considered() of nothing more, and of the best repeated motion
  Eigen::VectorXd masses_;           // half width by slot that is owed to uncertain masses
  Ranges widest_;                    // of joints, within the limits
};

}  // namespace hrp::diagnosis
