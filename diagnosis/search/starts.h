// SPDX-License-Identifier: BSD-3-Clause
// What may be added to a set of effects, and the values its parameters start from.
#pragma once

#include <memory>

#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {

// A set of effects fitted along the paths.
struct Lead {
  Hypothesis hypothesis;
  std::vector<double> train, held;     // chi2 by joint, of recordings fitted to and of the others
  std::shared_ptr<const Paths> paths;  // under this hypothesis
  double cost = 0.0;                   // sum of all chi2
};

// The joint whose readings alone an effect changes along the paths, or -1 when all joints feel it.
int find_joint(const Effect& effect);

// Whether an effect puts something that gives between a rotor and its link.
bool moves_link(const Effect& effect);

// Whether a set says something new with the effect added: not the same twice, no special case of another at its joint.
bool can_add(const Hypothesis& hypothesis, const Effect& added);

// Effects that could explain what a lead leaves, with start values: the `count` that promise most, and some of each
// joint and of the links; none that shows at `quiet` joints (by joint) alone. Changes the problem's view.
std::vector<Effect> list_starts(Problem& p, const Lead& lead, size_t count, const std::vector<char>& quiet);

// A rotor [kg m^2] behind a transmission that gives, and behind one with play.
std::vector<Effect> list_transmissions(int joint, double rotor_inertia);

// Start values of an effect: all combinations of the alternatives of its parameters, or of those only that no fit moves.
std::vector<Effect> list_options(const Effect& effect, bool scanned_only);

// Of such options, put at a place of a hypothesis, those that suit the recordings best as they are: the best first, no
// two with the same first parameter, at most `count`.
std::vector<Effect> choose_options(const Problem& problem, const std::vector<int>& recordings, Hypothesis hypothesis,
                                   size_t at, const std::vector<Effect>& options, size_t count);

}  // namespace hrp::diagnosis
