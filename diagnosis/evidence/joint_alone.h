// SPDX-License-Identifier: BSD-3-Clause
// Simulates one joint's drive while all other joints follow the recording. A fit of its effects costs about a twentieth
// of a fit through the whole robot.
#pragma once

#include "diagnosis/search/fit_residuals.h"

namespace hrp::diagnosis {

// True for effects of a joint's drive or of a joint's readings.
bool is_of_joint(const Effect& effect);
bool is_at(const Effect& effect, int joint);
Hypothesis take_joint(const Hypothesis& model, int joint);
// Effects of the model that do not belong to a joint.
Hypothesis take_links(const Hypothesis& model);

// Recorded paths of all joints, for bodies changed by the effects of `links`.
class JointPaths {
 public:
  JointPaths(const Problem& problem, const Hypothesis& links);
  JointPaths(const JointPaths&) = delete;
  // The problem of one joint. This object must outlive it.
  Problem view(int joint) const;

 private:
  Problem along_;
  Paths paths_;
};

// Fits and scores of one joint's effects along the recorded paths of the others.
class JointAlone {
 public:
  JointAlone(const JointPaths& paths, int joint);
  JointAlone(const JointAlone&) = delete;

  FitResult fit(const Hypothesis& start, int iterations) const { return fit(start, iterations, problem.train); }
  FitResult fit(const Hypothesis& start, int iterations, const std::vector<int>& recordings) const;
  // Score on the training recordings.
  Score score(const Hypothesis& h) const { return score(h, problem.train); }
  Score score(const Hypothesis& h, const std::vector<int>& recordings) const {
    return calc_score(residuals, 1, h, recordings);
  }
  // Fits until the gain per round is below 1 %, alternating a scan of pre-sliding displacements with a fit of all
  // parameters. Empty if no rollout stays finite or the result is no better than `start`.
  Hypothesis fit_to_the_end(const Hypothesis& start) const;

  const Problem problem;
  CalcResiduals residuals;  // of the simulation; EffortRows may add efforts
};

// Residuals of a hypothesis in the problem's simulated readings. The problem must outlive the function.
CalcResiduals make_residuals(const Problem& problem);

}  // namespace hrp::diagnosis
