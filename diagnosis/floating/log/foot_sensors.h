// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "diagnosis/floating/log/legged_log.h"

namespace hrp::diagnosis::floating {

// Whether a sensor under each foot tells the vertical force, and is of a kind.
template <class IsOfKind>
bool all_feel(const LeggedLog& log, const IsOfKind& is_of_kind) {
  return std::all_of(log.feet.begin(), log.feet.end(), [&](const Foot& f) {
    return f.sensor >= 0 && log.sensors[static_cast<size_t>(f.sensor)].axis[2] &&
           is_of_kind(log.sensors[static_cast<size_t>(f.sensor)]);
  });
}
inline bool all_feel(const LeggedLog& log) {
  return all_feel(log, [](const ForceSensor&) { return true; });
}
// The vertical force and no other.
inline bool all_feel_it_alone(const LeggedLog& log) {
  return all_feel(log, [](const ForceSensor& s) { return !s.has_force(); });
}

}  // namespace hrp::diagnosis::floating
