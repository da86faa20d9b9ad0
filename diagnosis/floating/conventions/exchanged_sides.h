// SPDX-License-Identifier: BSD-3-Clause
// Columns of left and right that are exchanged in a log: those of the feet's forces, of the legs' joints, or both.
// While the load goes from foot to foot, the feet then press on the one side of the body and its motion asks for the
// other one, and feet in the air bear loads.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis::floating {

struct ExchangedSides {
  std::vector<std::pair<std::string, std::string>> feet;  // sensors "l_foot" and "r_foot" of "/wrench/"
  std::vector<std::pair<int, int>> legs;                  // joints
  double left = 1;                                        // share in squares
  std::string rival;                                      // what leaves as little; empty: nothing
  bool any() const { return !feet.empty() || !legs.empty(); }
};

// Left and right are told by names that differ in them alone.
ExchangedSides find_exchanged_sides(const Experiment& experiment);

Experiment convert_sides(Experiment experiment, const ExchangedSides& exchanged);

// A sentence.
std::string describe(const ExchangedSides& exchanged);

}  // namespace hrp::diagnosis::floating
