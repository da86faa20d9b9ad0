// SPDX-License-Identifier: BSD-3-Clause
// [nats] What explanations cost before any recording speaks, and how much evidence settles a question. kOdds
// (significance.h) is the smallest step of this scale.
#pragma once

namespace hrp::diagnosis {

// Prior cost of one value at one of some places: the value, and which joint or link has it.
constexpr double kOneValue = 4.0;
// Evidence beside which a share or a count no longer matters: noise and a dozen free numbers do not gain so much.
constexpr double kOverwhelming = 20.0;

}  // namespace hrp::diagnosis
