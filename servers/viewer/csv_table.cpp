// SPDX-License-Identifier: BSD-3-Clause
#include "servers/viewer/csv_table.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>

#include "common/base/diagnostics.h"
#include "common/base/read_file.h"
#include "common/base/split_cells.h"

namespace hrp {
namespace {

std::vector<std::string> split_without_quotes(std::string line) {
  line.erase(std::remove_if(line.begin(), line.end(), [](char c) { return c == '\r' || c == '"'; }), line.end());
  return split_cells(line);
}

double read_number(const std::string& cell, const InputPlace& place, size_t column) {
  if (cell.empty()) return std::numeric_limits<double>::quiet_NaN();
  char* end = nullptr;
  const double value = std::strtod(cell.c_str(), &end);
  if (*end != '\0')
    refuse_input({place.file, "", place.line, static_cast<int>(column) + 1},
                 "'" + cell + "' is no number (columns count cells)");
  return value;
}

}  // namespace

const std::vector<double>* CsvTable::find(const std::string& name) const {
  for (size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) return &columns[i];
  }
  return nullptr;
}

CsvTable read_csv_table(const std::string& path) {
  std::ifstream file(path);
  InputPlace place(path);
  if (!file) refuse_input(place, "cannot be read");
  CsvTable table;
  std::string line;
  while (std::getline(file, line)) {
    ++place.line;
    if (place.line == 1 && line.rfind("\xEF\xBB\xBF", 0) == 0) line.erase(0, 3);  // byte order mark
    if (line.empty() || line[0] == '#' || line == "\r") continue;
    const std::vector<std::string> cells = split_without_quotes(line);
    if (table.names.empty()) {
      table.names = cells;
      table.columns.resize(cells.size());
      if (!table.find("time")) refuse_input(place, "expected a header line with a column 'time'");
      continue;
    }
    if (cells.size() != table.names.size()) {
      table.notes.push_back("line " + std::to_string(place.line) + " has " + std::to_string(cells.size()) +
                            " cells, not " + std::to_string(table.names.size()) + ": left out");
      continue;
    }
    for (size_t i = 0; i < cells.size(); ++i) table.columns[i].push_back(read_number(cells[i], place, i));
  }
  check_end(file, path);
  if (table.names.empty()) refuse_input(place, "is empty");
  if (table.columns[0].empty()) refuse_input(place, "has a header and no row");
  return table;
}

}  // namespace hrp
