// SPDX-License-Identifier: BSD-3-Clause
// Recordings as tables: comma-separated values (one header line, one line a sample), or a log of a run (MCAP).
#pragma once

#include <string>
#include <vector>

namespace hrp::diagnosis {

struct Table {
  std::string file;
  std::vector<std::string> names;              // of the columns, as in the header
  std::vector<std::vector<double>> columns;    // by column; NaN where a cell is empty or says nan
  // Line of the file that each row came from, 1 = header; of a log the number of the sample, counted likewise.
  std::vector<int> lines;
  int find(const std::string& name) const;     // -1 when there is no such column
  size_t rows() const { return lines.size(); }
};

// Throws InputError with file, line and column (1 = first cell of the line) of what cannot be read. Empty lines and
// lines that begin with # are skipped; a last line that was cut off (too few cells) is dropped with a warning, any
// other such line is an error.
Table read_csv(const std::string& path, std::vector<std::string>* warnings);

// A log of ours as the same table: signals have the same names. Throws InputError.
Table read_mcap(const std::string& path, std::vector<std::string>* warnings);

// By the end of the name: `.mcap` is a log, anything else is text.
Table read_recording_table(const std::string& path, std::vector<std::string>* warnings);

}  // namespace hrp::diagnosis
