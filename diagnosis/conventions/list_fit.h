// SPDX-License-Identifier: BSD-3-Clause
// How well effects on the list can explain recordings at all: for questions that are asked before the diagnosis, such
// as whether a log counts from another zero or at another time.
#pragma once

#include <vector>

#include "diagnosis/evidence/torque/design.h"
#include "diagnosis/evidence/torque/model.h"

namespace hrp::diagnosis {

// Another convention of a log must explain more than every set of effects as logged by kWholeGain, as a term of the
// whole robot must.

// What explains: all effects on the list, or only those of joints and their drives.
enum class Of { kAll, kJoints };

// The best that effects on the list can do for these recordings.
struct ListFit {
  std::vector<double> cross, effective;  // by joint: mean square left over its effort's, and independent samples
  std::vector<double> square;  // by joint [(N m)^2]: that of its effort; of a passive joint, of weight and inertia
  double cost = 0.0;           // [nats] of its terms

  bool is_exact() const;
};

// Empty if no joint can be judged.
ListFit fit_list(const Experiment& e, int jobs, Of of = Of::kAll);
// The same of recordings whose design is there already.
ListFit fit_list(const TorqueDesign& design, int jobs, Of of = Of::kAll);

// [nats] by which a is the better explanation. What the richer of two sets of terms leaves is less correlated, which is
// no merit: both count the same samples.
double compare(const ListFit& a, const ListFit& b);

// The same in N m. For models that differ in what weight and inertia take, such as those of two directions of gravity:
// what is left of a passive joint's torque is no share of it.
double compare_torques(const ListFit& a, const ListFit& b);

}  // namespace hrp::diagnosis
