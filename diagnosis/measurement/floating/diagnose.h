// SPDX-License-Identifier: BSD-3-Clause
// Robots on their feet, standing or walking, with whatever sensors they have.
#pragma once

#include <functional>

#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis {
struct Experiment;
}

namespace hrp::diagnosis::floating {

struct LeggedReport {
  Evidence evidence;
  bool judged = false;  // something was compared
  bool walks = false;   // a foot leaves the ground and comes back
  nlohmann::ordered_json series;
};

// `only_walks`: a robot that stands is left to others; `judged` is false then.
LeggedReport diagnose_legged(const Experiment& experiment, const std::function<void(const std::string&)>& progress,
                             bool only_walks = false);

}  // namespace hrp::diagnosis::floating
