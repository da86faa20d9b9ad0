// SPDX-License-Identifier: BSD-3-Clause
// Converts a table to a recording: time stamps, joints of the model, and all other columns by name.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// [s] Mean time between samples. Four samples per second do not show the motion of a joint, and no robot logs at 1 MHz.
constexpr double kLongestStep = 0.25, kShortestStep = 1e-6;

// Throws InputError with file, line and column: for stamps that decrease or are not in seconds, and for unknown joints.
Recording make_recording(const Experiment& experiment, const RecordingSpec& spec, const Table& table,
                         std::vector<std::string>* warnings);

// Name of the joint of a column of readings or commands; empty for other columns.
std::string get_joint(const std::string& column);

}  // namespace hrp::diagnosis
