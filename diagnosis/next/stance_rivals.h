// SPDX-License-Identifier: BSD-3-Clause
// What may be at a joint whose mismatch no effect of a report explains.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/data/recording.h"
#include "diagnosis/report/json.h"

namespace hrp::diagnosis {

// A joint that a report cannot explain, and the effort [N m or N] that is missing there (rms).
struct Riddle {
  std::string joint;
  double missing = 0.0;
};

// The joints of a report's `unexplained`, loudest first, whose missing effort the report states.
std::vector<Riddle> list_riddles(const Experiment& experiment, const Json& report);

// Effects of the drive, each as large as it must be to need that effort along the recordings: dry friction, viscous
// friction, a spring, a wrong torque constant. Empty if the joint did not move at all.
Json list_joint_rivals(const Experiment& experiment, const Riddle& riddle);

}  // namespace hrp::diagnosis
