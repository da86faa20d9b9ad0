// SPDX-License-Identifier: BSD-3-Clause
// Torque that ripples with a joint's position: which periods its missing torque shows.
#pragma once

#include <vector>

#include "diagnosis/measurement/torque.h"

namespace hrp::diagnosis {

// N [1/rad] of the highest peaks in the periodogram of the joint's missing torque over its position, training, beside
// friction, rotor, load and a constant; highest first, at most three. Ripples of fewer than one and a half periods within the joint's
// travel look like a spring or gravity; those that pass faster than the cutoff are filtered out. Parts of the recordings must
// agree on a ripple's phase. Empty where none stands out.
std::vector<double> find_ripples(const TorqueData& data, int joint);

}  // namespace hrp::diagnosis
