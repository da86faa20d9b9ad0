// SPDX-License-Identifier: BSD-3-Clause
// Effects at a joint that stand in for something else, by what other joints and other findings say.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/floating/search/state.h"

namespace hrp::diagnosis::floating {

struct StandIn {
  size_t effect;    // of `found`; its size: there is none
  std::string why;  // for whoever follows the search
};

StandIn find_stand_in(const std::vector<FoundEffect>& found, const SearchState& state);

}  // namespace hrp::diagnosis::floating
