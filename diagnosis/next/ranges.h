// SPDX-License-Identifier: BSD-3-Clause
// What joints have been through.
#pragma once

#include <utility>
#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Lowest and highest position of each joint [rad or m].
using Ranges = std::vector<std::pair<double, double>>;

double calc_range(const Ranges& ranges, int joint);

void widen(const std::vector<double>& positions, std::pair<double, double>* range);

// Of the recordings for training.
Ranges list_seen(const Experiment& experiment);

}  // namespace hrp::diagnosis
