// SPDX-License-Identifier: BSD-3-Clause
// Effects that may be added to a set, and start values of their parameters.
#pragma once

#include <memory>

#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {

// A set of effects that was fitted along recorded paths.
struct Lead {
  Hypothesis hypothesis;
  std::vector<double> train, held;     // chi2 by joint, of training and held-out recordings
  std::shared_ptr<const Paths> paths;  // computed under this hypothesis
  double cost = 0.0;                   // sum of all chi2
};

// The joint whose readings alone an effect changes along the paths; -1 if it changes those of all joints.
int find_joint(const Effect& effect);

// True for elastic or loose transmissions between a rotor and its link.
bool moves_link(const Effect& effect);

// True if an effect adds something new: it is not in the set, and no special case of another effect at its joint.
bool can_add(const Hypothesis& hypothesis, const Effect& added);

// Effects that could explain the residual of a lead, with start values: the `count` best ones, and some of each joint
// and of the links. None that changes only the readings of a `quiet` joint (flag by joint). Changes the problem's view.
std::vector<Effect> list_starts(Problem& p, const Lead& lead, size_t count, const std::vector<char>& quiet);

// A rotor of this inertia [kg m^2] behind each kind of transmission: elastic, loose.
std::vector<Effect> list_transmissions(int joint, double rotor_inertia);

// Start values of an effect: all combinations of its parameters' alternatives. `scanned_only`: only of scanned
// parameters.
std::vector<Effect> list_options(const Effect& effect, bool scanned_only);

// Puts the options into the hypothesis at index `at` and returns the best ones without fitting. Best first, no two with
// the same first parameter, at most `count`.
std::vector<Effect> choose_options(const Problem& problem, const std::vector<int>& recordings, Hypothesis hypothesis,
                                   size_t at, const std::vector<Effect>& options, size_t count);

}  // namespace hrp::diagnosis
