// SPDX-License-Identifier: BSD-3-Clause
// A robot whose base stands still is as many robots as it has subtrees: a leg of a robot that hangs from its trunk does not
// feel what the other one does. Each is searched by itself, at a fraction of the cost: a mass matrix of 29 joints costs
// as much as those of 20 legs.
#pragma once

#include "diagnosis/search/search.h"

namespace hrp::diagnosis {

// Joints by subtree, in the order of the tree. Joints that follow each other (mimic) are of one subtree.
std::vector<std::vector<int>> list_subtrees(const TreeSpec& tree);

// Fills problem->subtrees where there is more than one.
void split_subtrees(Problem* problem);

// The effects of the whole robot that a subtree feels, by the numbers of its own joints and links.
Hypothesis select_effects(const Hypothesis& whole, const Subtree& subtree);

// As calc_residuals of the whole robot, subtree by subtree.
bool calc_subtree_residuals(const Problem& problem, const Hypothesis& hypothesis, int recording,
                         std::vector<double>* residuals);

// Searches each subtree; what is found in all of them is one outcome of the whole robot. Without subtrees the same as search.
Outcome search_subtrees(const Problem& problem, const Progress& progress);

// The problem with simulations that begin where a trial's did.
Problem start_as(const Problem& problem, const Trial& trial);

}  // namespace hrp::diagnosis
