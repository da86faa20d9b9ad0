// SPDX-License-Identifier: BSD-3-Clause
// Long recordings hold more than a fit by simulation needs. It would take an hour; the missing torque takes seconds.
#pragma once

#include <optional>

#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {

// What a model is fitted to by simulation: the recordings of a problem or, of those above 600 joint-seconds, the
// stretches in which the joints move most. Both problems must outlive it.
class FittedPart {
 public:
  // `whole`: `problem` with its subtrees.
  FittedPart(const Problem& problem, const Problem& whole);
  FittedPart(const FittedPart&) = delete;

  bool is_cut() const { return experiment_.has_value(); }
  double seconds() const;  // of the robot's motion
  const Problem& problem() const { return experiment_ ? part_ : given_; }
  const Problem& whole() const { return experiment_ ? whole_part_ : given_whole_; }

 private:
  const Problem& given_;
  const Problem& given_whole_;
  std::optional<Experiment> experiment_;
  Problem part_, whole_part_;
};

}  // namespace hrp::diagnosis
