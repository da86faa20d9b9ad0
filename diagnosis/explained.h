// SPDX-License-Identifier: BSD-3-Clause
// How well effects on the list explain recordings of a fixed base, with zeros, units and gravity as they are given.
#pragma once

#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

constexpr double kClearNats = 5.0;  // by which another reading of the log must explain more than every set of effects: odds of 150

// What explains: all effects on the list, or only those of joints and their drives.
enum class Of { kAll, kJoints };

// The best that effects on the list can do for these recordings.
struct Explained {
  std::vector<double> cross, effective;  // by joint: mean square left over its effort's, and independent samples
  double cost = 0.0;                     // [nats] of its terms

  bool is_exact() const;
};

// Empty if no joint can be judged.
Explained explain(const Experiment& experiment, int jobs, Of of = Of::kAll);

// [nats] by which a is the better explanation. What the richer of two sets of terms leaves is less correlated, which is no
// merit: both count the same samples.
double compare(const Explained& a, const Explained& b);

}  // namespace hrp::diagnosis
