// SPDX-License-Identifier: BSD-3-Clause
// Comparisons whose units are whole recordings: weight, accelerometers at rest, force readings that are no newtons,
// feet that slip, heights of standing feet in the base's recorded pose. They need few sensors and say little each.
#pragma once

#include "diagnosis/measurement/floating/candidates.h"
#include "diagnosis/measurement/floating/row_table.h"

namespace hrp::diagnosis::floating {

struct CheckResult {
  std::vector<Finding> findings;
  std::vector<std::string> notes;  // what agrees, and what a comparison could not use
  bool raw_counts = false;         // forces are in an unknown unit: nothing of masses and friction can be told
};

CheckResult run_checks(const LeggedLog& log, const Contacts& contacts, const std::vector<ChannelRows>& channels,
                       const ColumnLayout& layout);

// Mean and standard error of what recordings say; those far from the median, by more than `least` and by more than the
// others scatter, are set aside and counted.
struct Consensus {
  double mean = 0, std = 0;
  size_t kept = 0, odd = 0;
};
Consensus find_consensus(std::vector<double> values, double least);

// How sharply side forces over normal forces break off at a limit. Friction cuts off what loaded feet would ask for: many
// are at the limit, few beyond. Counts below, at and beyond it, in bins that grow alike, are n0 n1 n2; n1^2 / (n0 n2) is 1
// where they fall off exponentially. 0: hardly any are there.
double calc_break(const std::vector<double>& ratios, double limit);

}  // namespace hrp::diagnosis::floating
