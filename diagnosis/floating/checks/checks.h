// SPDX-License-Identifier: BSD-3-Clause
// Comparisons whose units are whole recordings: weight, accelerometers at rest, force readings that are no newtons,
// feet that slip, heights of standing feet in the base's recorded pose. They need few sensors and say little each.
#pragma once

#include "diagnosis/floating/fit/candidates.h"
#include "diagnosis/floating/fit/row_table.h"
#include "diagnosis/floating/log/contacts.h"

namespace hrp::diagnosis::floating {

// What scales and zeros of counts, or faults of sensors of vertical forces, leave of the weight: mean squares [N^2],
// rows, by part (train, validate).
struct UnitFit {
  std::string signal;  // empty: nothing was corrected
  double before[2] = {0, 0}, after[2] = {0, 0}, rows[2] = {0, 0};
  double exact = 1;  // [N^2] of what no model of masses is more exact than
  double scale = 0;  // [N] spread of what is compared
};

struct CheckResult {
  std::vector<Finding> findings;
  // Faults that the recordings are rid of before the search: what it finds adds to them
  std::vector<Finding> corrected;
  std::vector<Remaining> remaining;  // what is seen and has no one cause
  std::vector<std::string> notes;    // what agrees, and what a comparison could not use
  std::vector<Candidate> weight;  // what the feet carry too much or too little, as a mass: to fit beside what is chosen
  UnitFit units;
  bool raw_counts = false;  // forces are in an unknown unit: nothing of masses and friction can be told
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

// A loaded foot at one moment.
struct Slide {
  size_t recording = 0;
  double speed = 0;    // along the ground [m/s]
  double ratio = 0;    // side force over normal force
  double against = 0;  // cosine of the angle between the side force and the way back
};

// What feet that slide ask for of the ground, and its error. Zero where most side forces do not point back: no friction
// drives a foot on. Feet that turn, or are dragged aside, do not count.
std::pair<double, double> find_sliding_friction(const std::vector<Slide>& slides);

}  // namespace hrp::diagnosis::floating
