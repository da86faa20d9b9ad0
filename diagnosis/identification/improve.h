// SPDX-License-Identifier: BSD-3-Clause
// Motions that tell more about the rubber in the feet. They come from the machine that proposes the next experiment:
// its families of motions on the feet (next/stance_motions.h), as large as they are safe, chosen by Fisher information.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/identification/motions.h"

namespace hrp::identification {

struct ProposedMotion {
  std::string name, meaning;
  MotionCheck check;
  double largest = 0.0;  // as find_largest_deviation, of all motions up to this one
};

// The least known stiffness [N m/rad], or damping at the rate at which both matter alike, of all motions together:
// expected standard deviation where the torque's noise is 1 N m in a band of 1 Hz.
double find_largest_deviation(const std::vector<MotionCheck>& checks);

// Motions of `seconds` into the folder, best first, for a robot that does `known` already: `seeds` of each family are
// tried. Another one is proposed as long as it takes a twentieth off the largest deviation.
std::vector<ProposedMotion> propose_motions(const Scenario& base, std::vector<MotionCheck> known, int seeds,
                                            double seconds, const std::string& folder);

}  // namespace hrp::identification
