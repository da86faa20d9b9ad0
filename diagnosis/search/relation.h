// SPDX-License-Identifier: BSD-3-Clause
// What a series follows: free functions of one or two quantities, learnt on some recordings and judged on others.
#pragma once

#include <string>
#include <vector>

namespace hrp::diagnosis {

// One recording: the series, and the quantities it may follow, a row of samples each.
struct Observed {
  std::vector<double> time;  // [s]
  std::vector<double> y;
  std::vector<std::vector<double>> x;
};

struct Regressor {
  std::string name;   // as reported: position, velocity, direction, load, time, history
  std::string words;  // in a sentence
  std::string unit;   // of its values; empty where a range of them says nothing, and of another joint's position
  bool pairs = true;  // whether it may stand beside another
};

struct Relation {
  double share = 0.0;              // of the held-out squares that it takes away; the rest is noise or something else
  std::vector<std::string> names;  // of the quantities, those that say most first; empty: none is followed
  std::string words;               // the same for people, with what is known of the function's shape
};

struct Oscillation {
  double frequency = 0.0;  // [Hz]
  double share = 0.0;      // of the held-out squares
};

// The sinusoid of time above `lowest` [Hz] that says most; in proportion to quantity `factor` where that is not -1. Its
// frequency is learnt; amplitude and phase are each recording's own.
Oscillation find_oscillation(const std::vector<Observed>& train, const std::vector<Observed>& test, double lowest,
                             int factor = -1);

// The relation that says most with least: a second quantity has to take away a good part of what the first one leaves.
// Time may act as a slow change, the same in all recordings, or as an oscillation, whose frequency is theirs in common.
Relation find_relation(const std::vector<Regressor>& quantities, const std::vector<Observed>& train,
                       const std::vector<Observed>& test);

}  // namespace hrp::diagnosis
