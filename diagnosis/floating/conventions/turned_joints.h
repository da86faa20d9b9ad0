// SPDX-License-Identifier: BSD-3-Clause
// Joints of which a log counts something the other way than the model's axes.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis::floating {

struct TurnedJoints {
  std::vector<int> joints;
  double left = 1.0;  // share in squares of what speaks against the logged signs
};

// Turns the joints that `find` names, as long as it names new ones. `find` gets the experiment with those turned that
// were named before, and multiplies `left` by the share that its own joints leave.
TurnedJoints turn_joints(const Experiment& experiment,
                         const std::function<std::vector<int>(const Experiment&, double* left)>& find,
                         const std::function<Experiment(Experiment, const TurnedJoints&)>& convert);

// A sentence without its stop. `fault`: what is wrong; `rest`: of what a share is left.
std::string describe(const Experiment& experiment, const TurnedJoints& turned, const std::string& fault,
                     const std::string& rest);

}  // namespace hrp::diagnosis::floating
