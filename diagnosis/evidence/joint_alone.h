// SPDX-License-Identifier: BSD-3-Clause
// One joint's drive, simulated with all other joints as recorded: fits of its effects, some twenty times cheaper than
// through the whole robot.
#pragma once

#include "diagnosis/search/fit_residuals.h"

namespace hrp::diagnosis {

// Of a joint's drive, or of the readings of its drive.
bool is_of_joint(const Effect& effect);
bool is_at(const Effect& effect, int joint);
Hypothesis take_joint(const Hypothesis& model, int joint);
// Effects of the model that are of no joint.
Hypothesis take_links(const Hypothesis& model);

// Recorded paths of all joints, bodies as the effects of links make them.
class JointPaths {
 public:
  JointPaths(const Problem& problem, const Hypothesis& links);
  JointPaths(const JointPaths&) = delete;
  // Of one joint; this must outlive it.
  Problem view(int joint) const;

 private:
  Problem along_;
  Paths paths_;
};

class JointAlone {
 public:
  JointAlone(const JointPaths& paths, int joint);
  JointAlone(const JointAlone&) = delete;

  FitResult fit(const Hypothesis& start, int iterations) const { return fit(start, iterations, problem.train); }
  FitResult fit(const Hypothesis& start, int iterations, const std::vector<int>& recordings) const;
  // Of the training recordings.
  Score score(const Hypothesis& h) const { return score(h, problem.train); }
  Score score(const Hypothesis& h, const std::vector<int>& recordings) const { return calc_score(residuals, 1, h, recordings); }
  // To the end; empty where no rollout stays finite, or nothing is better than the start. Displacements before slipping
  // and what follows from them move in turn: each round brings less.
  Hypothesis fit_to_the_end(const Hypothesis& start) const;

  const Problem problem;
  CalcResiduals residuals;  // of the simulation; efforts may be added
};

// What a hypothesis leaves of a problem's simulated readings. The problem must outlive it.
CalcResiduals make_residuals(const Problem& problem);

}  // namespace hrp::diagnosis
