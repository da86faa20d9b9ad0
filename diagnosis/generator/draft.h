// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "diagnosis/generator/dirt.h"
#include "diagnosis/generator/recorder.h"

namespace hrp::cases {

// Everything that is drawn of a case, before it runs.
struct Draft {
  RobotPlan robot;
  std::vector<Hidden> hidden;
  Dirt dirt;  // of worlds like reality; else empty
  RecorderPlan recorder;
  std::vector<RecordingPlan> recordings;
  std::vector<Commands> commands;
  std::vector<std::vector<double>> times;
};

// What is hidden and, of dirty worlds, what is everywhere.
std::vector<Hidden> list_listed(const Draft& draft);
std::vector<Hidden> list_all(const Draft& draft);

// What is there in one recording: loads last, whatever is wrong with the robot's own masses.
std::vector<Hidden> list_in(const Draft& draft, std::size_t recording);

// Recording `i` as planned.
std::vector<Column> record_planned(const Draft& draft, const RecorderPlan& recorder, std::size_t i, Prng& random);

// Recording `i` up to `until` seconds, without noise.
std::vector<Column> record_clean(const Draft& draft, const std::vector<Hidden>& hidden, std::size_t i, double until);

// Deviation used to judge a column: what the recorder adds to it.
double find_noise(const Draft& draft, const std::string& column);

}  // namespace hrp::cases
