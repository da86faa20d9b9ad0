// SPDX-License-Identifier: BSD-3-Clause
// Effects with memory: their state along a path.
#pragma once

#include <Eigen/Core>

#include "common/effects/effect_info.h"

namespace hrp::diagnosis {

// State [1] of an effect with memory, relative to its largest value, by sample along positions [rad]. It starts at zero
// and forgets the time before within a few yield angles. `shape`: the effect's shape parameter, as a yield angle [rad].
Eigen::VectorXd calc_memory_state(const EffectInfo& effect, const Eigen::VectorXd& q, double shape);

}  // namespace hrp::diagnosis
