// SPDX-License-Identifier: BSD-3-Clause
// A motion as if it had been recorded from a robot of which an explanation is true.
#pragma once

#include <memory>

#include "diagnosis/next/motions.h"
#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {

// The experiment and its problem, with this motion as the only recording. It must not move: the problem points to it.
struct TrialMotion {
  Experiment experiment;
  Problem problem;
};

// `bare`: the experiment without its recordings. `like`: a recording of it, whose columns the new one has. `loads` hang on
// the robot.
std::unique_ptr<TrialMotion> make_trial_motion(const Experiment& bare, const Recording& like, const Commands& commands,
                                               const Hypothesis& truth, const std::vector<LoadSpec>& loads = {});

// Readings [sample][joint][quantity] of the whole robot under an explanation; false: the motion left all bounds.
bool simulate_trial(const TrialMotion& motion, const Hypothesis& hypothesis, std::vector<double>* readings);

}  // namespace hrp::diagnosis
