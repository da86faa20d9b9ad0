// SPDX-License-Identifier: BSD-3-Clause
// The section `columns` of an experiment: which columns of a text recording hold which signals
// (docs/text_recordings.md).
#pragma once

#include <string>
#include <vector>

namespace hrp {

// One signal and where it stands: value = scale * cell + offset.
struct SignalColumn {
  std::string signal;  // "time", "/joint_states/hip/position", ...
  std::string name;    // of the column in the file's header; empty: by number
  int number = 0;      // from 1
  double scale = 1.0, offset = 0.0;
};

struct ColumnMap {
  std::vector<SignalColumn> columns;  // empty: the file's header names the signals
  double sample_rate = 0.0;           // [Hz] of files without a column of time, the key `sample_rate`; 0: not stated
};

// From the text of an experiment file, one for each of its recordings: `columns` of the experiment and of the
// recording, which goes first. Throws InputError with file, line, column.
std::vector<ColumnMap> parse_column_maps(const std::string& text, const std::string& path);

}  // namespace hrp
