// SPDX-License-Identifier: BSD-3-Clause
// Limits of the same probability as a number of normal deviations (significance.h), for other questions than one error
// of a known deviation.
#pragma once

#include <cstddef>

namespace hrp::diagnosis {

// Limit in standard deviations with the probability of `normal` deviations, if the deviation itself is estimated from
// `degrees` independent errors. Student's t by Wallace's approximation, accurate to 1 % from four degrees on.
double find_student(double normal, double degrees);

// Limit on the length of a vector of `components` (1 to 3) independent unit normal errors. It has the probability that
// one error exceeds `normal` standard deviations.
double find_length(double normal, size_t components);

}  // namespace hrp::diagnosis
