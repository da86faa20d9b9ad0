// SPDX-License-Identifier: BSD-3-Clause
// A robot whose base stands still is as many robots as it has limbs: a leg of a robot that hangs from its trunk does not
// feel what the other one does. Each is searched by itself, at a fraction of the cost: a mass matrix of 29 joints costs
// as much as those of 20 legs.
#pragma once

#include "diagnosis/search/search.h"

namespace hrp::diagnosis {

// Joints by limb, in the order of the tree. Joints that follow each other (mimic) are of one limb.
std::vector<std::vector<int>> list_limbs(const TreeSpec& tree);

// Fills problem->limbs where there is more than one.
void split_limbs(Problem* problem);

// The effects of the whole robot that a limb feels, by the numbers of its own joints and links.
Hypothesis select_effects(const Hypothesis& whole, const Limb& limb);

// As calc_residuals of the whole robot, limb by limb.
bool calc_limb_residuals(const Problem& problem, const Hypothesis& hypothesis, int recording,
                         std::vector<double>* residuals);

// Searches each limb; what is found in all of them is one outcome of the whole robot. Without limbs the same as search.
Outcome search_limbs(const Problem& problem, const Progress& progress);

// The problem with simulations that begin where a trial's did.
Problem start_as(const Problem& problem, const Trial& trial);

}  // namespace hrp::diagnosis
