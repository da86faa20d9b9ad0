// SPDX-License-Identifier: BSD-3-Clause
// Finds torque ripple over a joint's position in its missing torque.
#pragma once

#include <vector>

#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

// Wave numbers [1/rad] of the highest peaks in the periodogram of the missing torque over the position, highest first,
// at most three. Training samples, beside friction, rotor, load and a constant. Ripples with less than one and a half
// periods within the joint's travel look like a spring or gravity, and the filter removes those that pass faster than
// the cutoff; both are left out. Parts of the recordings must agree about the phase. Empty if no peak is significant.
std::vector<double> find_ripples(const TorqueData& data, int joint);

}  // namespace hrp::diagnosis
