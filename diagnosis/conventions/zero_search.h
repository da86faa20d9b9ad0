// SPDX-License-Identifier: BSD-3-Clause
// Zeros of joints that are off by more than a linear term of an effect tells, against every other effect of the list.
#pragma once

#include <vector>

#include "diagnosis/measurement/joint_zeros.h"

namespace hrp::diagnosis {

// Empty if other effects explain the recordings as well. Throws InputError, with the column, where a joint turns the
// other way.
std::vector<JointZero> find_zeros(const Experiment& experiment, int jobs);

}  // namespace hrp::diagnosis
