// SPDX-License-Identifier: BSD-3-Clause
// Joints whose effort was recorded with the opposite sign: drives count it on the motor rather than on the link, or a
// driver turns it. The recordings are judged with the model's sign, and the log's fault is a finding of its own.
#pragma once

#include <vector>

#include "diagnosis/data/recording.h"
#include "diagnosis/report/json.h"

namespace hrp::diagnosis {

struct TurnedEffort {
  int joint = 0;
  bool or_angle = false;  // turned positions and rates explain the torque as well
};

// The recordings with the efforts of these joints in the model's sense.
Experiment turn_efforts(Experiment experiment, const std::vector<TurnedEffort>& turned);

// Every joint whose effort was recorded: a driver may turn them all.
std::vector<TurnedEffort> list_efforts(const Experiment& experiment);

// Turns the effort of this joint, or of all joints if that explains clearly more; turns it back if it was one of all.
// Throws InputError if another gravity explains the efforts clearly better. `experiment` is without the turns of the
// list.
void add_turned_effort(const Experiment& experiment, int joint, int jobs, std::vector<TurnedEffort>* turned);

// `share`: of the mismatch of the effort that goes away with the other sign.
Json make_turned_finding(const Experiment& experiment, const TurnedEffort& turned, double share);

}  // namespace hrp::diagnosis
