// SPDX-License-Identifier: BSD-3-Clause
// A recording from the columns of a table: its time stamps, the joints of the model, and everything else by name.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Throws InputError with file, line and column: stamps that go back or are not in seconds, joints that the model has not.
Recording make_recording(const Experiment& experiment, const RecordingSpec& spec, const Table& table,
                         std::vector<std::string>* warnings);

// The joint of a column of readings or commands; empty: it is none.
std::string get_joint(const std::string& column);

}  // namespace hrp::diagnosis
