// SPDX-License-Identifier: BSD-3-Clause
// What all proposers share: the worth of a motion, and the head of a proposal.
#pragma once

#include "diagnosis/next/information.h"
#include "diagnosis/next/propose.h"

namespace hrp::diagnosis {

// `decided` (mean probability of a decision) plus half of the expected narrowing of the intervals, at most
// one and a half. An interval counts fully if it becomes a fourth of what it was. `before` and `after`: the same
// parameters without and with the motion.
double calc_worth(double decided, const std::vector<ExpectedInterval>& before,
                  const std::vector<ExpectedInterval>& after);

// Parts of the half width of an interval that a motion changes: noise, the unseen part of a turn, and what the report
// considers (a torque constant, the time of a sample). `masses`: what it owes to masses that are known to 2 %. It
// stays, because a rotor and the inertia of links are the same function of every motion.
struct WidthParts {
  double noise = 0.0, unseen = 0.0, considered = 0.0, masses = 0.0;
};

// Half width to expect of an interval of this half width. Differences between recordings and regimes stay, because no
// motion removes them. Considered errors may grow: quick motions make the time of a sample matter more.
double calc_expected_width(double half_width, const WidthParts& before, const WidthParts& after);

// Factor on the worth: kDrawback for loads by hand, and for each proposal of the same family.
double calc_drawback(const MotionPlan& plan, const std::vector<Proposal>& proposals);

// True if the `number`-th proposal, from 0, is for validation.
bool is_held_out(size_t number);

// The `number`-th proposal, from 0, with file, plan, commands and worth. Motions train and validate in turn.
Proposal begin_proposal(size_t number, const MotionPlan& plan, const Commands& commands, double worth);

// rms difference [noise] over the samples of a comparison. `left`: the projected power.
double calc_rms(const Comparison& comparison, double left);

// Family of a motion, and whether it needs a load.
std::string describe_plan(const MotionPlan& plan);

}  // namespace hrp::diagnosis
