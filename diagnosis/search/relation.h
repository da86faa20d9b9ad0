// SPDX-License-Identifier: BSD-3-Clause
// Finds what a series depends on: free functions of one or two quantities, learnt on some recordings and judged on
// others.
#pragma once

#include <string>
#include <vector>

namespace hrp::diagnosis {

// One recording: the series, and the quantities that it may depend on, one row per quantity.
struct Observed {
  std::vector<double> time;  // [s]
  std::vector<double> y;
  std::vector<std::vector<double>> x;
};

// A quantity that a series may depend on.
struct Regressor {
  std::string name;   // as reported: position, velocity, direction, load, time, history
  std::string words;  // in a sentence of the report
  std::string unit;   // of its values; empty if a range of them means nothing, and for the position of another joint
  bool pairs = true;  // may be combined with a second quantity
};

struct Relation {
  double share = 0.0;              // share of the held-out squares that the relation explains
  std::vector<std::string> names;  // names of the quantities, most important first; empty: no relation
  std::string words;               // the same for people, with the shape of the function
};

struct Oscillation {
  double frequency = 0.0;  // [Hz]
  double share = 0.0;      // of the held-out squares
};

// Sinusoid of time above `lowest` [Hz] that explains most; proportional to quantity `factor` unless that is -1. The
// frequency is common to all recordings, amplitude and phase are fitted to each one.
Oscillation find_oscillation(const std::vector<Observed>& train, const std::vector<Observed>& test, double lowest,
                             int factor = -1);

// The simplest relation that explains most. A second quantity must remove a good part of what the first one leaves.
// Time may act as a slow change, the same in all recordings, or as an oscillation with a common frequency.
Relation find_relation(const std::vector<Regressor>& quantities, const std::vector<Observed>& train,
                       const std::vector<Observed>& test);

}  // namespace hrp::diagnosis
