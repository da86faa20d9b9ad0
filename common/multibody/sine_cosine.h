// SPDX-License-Identifier: BSD-3-Clause
// Sines and cosines of many angles at once: branch-free, so that compilers turn the loop into vector code, and the same
// bits on every machine, whichever mathematics library it has.
#pragma once

namespace hrp {

// sine[i], cosine[i] of angle[i] [rad], error below 2e-16. Angles above 1e5 take the library's functions.
void calc_sine_cosine(const double* angle, int n, double* sine, double* cosine);

}  // namespace hrp
