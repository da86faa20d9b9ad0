// SPDX-License-Identifier: BSD-3-Clause
// Recordings as tables: comma-separated values (a header line, one line per sample) or the log of a run (MCAP).
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace hrp::diagnosis {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();  // where a table has no number

struct Table {
  std::string file;
  std::vector<std::string> names;            // of the columns, as in the header
  std::vector<int> numbers;                  // of the columns in the file, from 1; empty: they are all of its columns
  std::vector<std::vector<double>> columns;  // by column; kMissing where a cell is empty or says nan
  // Line of the file that each row came from, 1 = header; of a log the number of the sample, counted likewise.
  std::vector<int> lines;
  int find(const std::string& name) const;  // -1 when there is no such column
  int number_of(int column) const;          // in the file, from 1, for messages
  size_t rows() const { return lines.size(); }
};

// Reads a text recording. Throws InputError with file, line and column (1 = first cell) of an error. Skips empty lines
// and lines that start with #. Drops a truncated last line (too few cells) with a warning; any other such line is an
// error.
Table read_csv(const std::string& path, std::vector<std::string>* warnings);

// Reads a log of this project as the same table, with the same signal names. Throws InputError.
Table read_mcap(const std::string& path, std::vector<std::string>* warnings);

// Chooses the reader by the end of the name: `.mcap` is a log, everything else is text.
Table read_recording_table(const std::string& path, std::vector<std::string>* warnings);

}  // namespace hrp::diagnosis
