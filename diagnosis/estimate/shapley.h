// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

namespace hrp::diagnosis {

// Above so many players their last steps are taken instead: 2^n values are too many.
constexpr size_t kMostPlayers = 6;

// What each of several players adds to what all of them reach together, averaged over all orders in which they can come
// (Shapley 1953). The results sum to value(all) - value(none). Bit i of the mask says that player i is there. With more
// than `most` players: what the value lacks without each.
std::vector<double> calc_shapley(size_t players, const std::function<double(size_t mask)>& value,
                                 size_t most = kMostPlayers);

}  // namespace hrp::diagnosis
