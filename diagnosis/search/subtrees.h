// SPDX-License-Identifier: BSD-3-Clause
// Splits a robot on a fixed base into its independent subtrees: one leg of a robot that hangs from its trunk does not
// affect the other. Each is searched alone, at a fraction of the cost: a mass matrix of 29 joints costs as much as
// those of 20 legs.
#pragma once

#include "diagnosis/search/search.h"

namespace hrp::diagnosis {

// Joints by subtree, in the order of the tree. Joints coupled by `mimic` belong to one subtree.
std::vector<std::vector<int>> list_subtrees(const TreeSpec& tree);

// Fills problem->subtrees if there are several.
void split_subtrees(Problem* problem);

// Effects of the whole robot that act on a subtree, in its own numbering of joints and links.
Hypothesis select_effects(const Hypothesis& whole, const Subtree& subtree);

// The other way: a subtree's effects in the numbering of the whole robot.
Hypothesis map_to_robot(const Hypothesis& own, const Subtree& subtree);

// As calc_residuals() of the whole robot, one subtree after another.
bool calc_subtree_residuals(const Problem& problem, const Hypothesis& hypothesis, int recording,
                            std::vector<double>* residuals);

// Searches each subtree and joins the outcomes. Without subtrees the same as search().
Outcome search_subtrees(const Problem& problem, const Progress& progress);

// The problem with a trial's start states and step errors.
Problem start_as(const Problem& problem, const Trial& trial);

}  // namespace hrp::diagnosis
