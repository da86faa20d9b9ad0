// SPDX-License-Identifier: BSD-3-Clause
// CSV recordings of experiment folders: column names as /joint_states/<joint>/position (docs/viewer.md lists them).
#pragma once

#include <map>
#include <string>
#include <vector>

namespace hrp {

struct CsvTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;  // not-a-number where a cell is empty
  std::vector<std::string> notes;            // lines that were left out

  // nullptr when there is no such column.
  const std::vector<double>* find(const std::string& name) const;
};

// Throws InputError with file, line and column when there is no header with a `time` column, no row, or a cell that is
// no number.
CsvTable read_csv_table(const std::string& path);

}  // namespace hrp
