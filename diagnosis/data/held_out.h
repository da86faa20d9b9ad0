// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// True if nothing is fitted to some recording (role: validate).
inline bool has_held_out(const std::vector<Recording>& recordings) {
  return std::any_of(recordings.begin(), recordings.end(), [](const Recording& r) { return !r.spec.train; });
}

}  // namespace hrp::diagnosis
