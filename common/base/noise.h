// SPDX-License-Identifier: BSD-3-Clause
// Noise of sensors that repeats to the bit.
#pragma once

namespace hrp {

// Standard normal number that depends on nothing but its arguments: the order of calls does not matter.
double calc_noise(unsigned long long seed, unsigned long long channel, unsigned long long step);

}  // namespace hrp
