// SPDX-License-Identifier: BSD-3-Clause
// A motion as if recorded from a robot for which an explanation is true.
#pragma once

#include <memory>

#include "diagnosis/next/motions.h"
#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {

// An experiment with this motion as its only recording, and its problem. It must not move in memory: the problem points
// to it.
struct TrialMotion {
  Experiment experiment;
  Problem problem;
};

// `bare`: the experiment without recordings. `like`: a recording whose columns the new one gets. `loads` hang on the
// robot.
std::unique_ptr<TrialMotion> make_trial_motion(const Experiment& bare, const Recording& like, const Commands& commands,
                                               const Hypothesis& truth, const std::vector<LoadSpec>& loads = {});

// The same with the commands as readings, for a robot that follows them, and with these efforts [N m] by joint.
std::unique_ptr<TrialMotion> make_followed_motion(const Experiment& bare, const Recording& like,
                                                  const Commands& commands,
                                                  const std::vector<std::vector<double>>& efforts,
                                                  const std::vector<LoadSpec>& loads = {});

// Readings [sample][joint][quantity] of the whole robot under an explanation; false if the motion exceeds all bounds.
bool simulate_trial(const TrialMotion& motion, const Hypothesis& hypothesis, std::vector<double>* readings);

}  // namespace hrp::diagnosis
