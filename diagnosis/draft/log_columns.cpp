// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/draft/log_columns.h"

#include <fstream>

#include "common/base/diagnostics.h"
#include "diagnosis/data/csv_layout.h"

namespace hrp::diagnosis {
namespace {

// The names in the first line, or in the comment before it, whatever they are, and the row below.
LogColumns read_names(const std::string& path) {
  std::ifstream file = open_text(path);
  LogColumns log;
  std::string comment;
  CsvLayout layout;
  for (std::string line; std::getline(file, line);) {
    if (is_blank(line)) {
      if (line.size() > 1) comment = line;
      continue;
    }
    log.table.file = path;
    if (layout.cells == 0) {
      layout = read_layout(line, comment, 1, {SignalColumn{"first", "", 1}}, &log.table);
      log.count = layout.cells;
      log.names = layout.names;
      if (layout.header) continue;
    }
    std::vector<Cell> cells;
    split_cells(layout, line, &cells);
    for (const Cell& cell : cells) log.first.push_back(trim_cell(cell));
    return log;
  }
  if (log.count == 0) refuse_input(path, "is empty: expected a table of samples");
  return log;
}

bool is_date(const std::string& text) {
  const Cell cell(text.data(), text.data() + text.size());
  double value = 0.0;
  return !parse_cell(cell, ',', &value) && parse_stamp(cell, &value);
}

}  // namespace

LogColumns read_log_columns(const std::string& path) {
  LogColumns log = read_names(path);
  ColumnMap all;
  for (size_t i = 0; i < log.count; ++i) {
    // Cells of time alone are read as dates or times of day.
    const std::string signal =
        i < log.first.size() && is_date(log.first[i]) ? "time" : "column " + std::to_string(i + 1);
    all.columns.push_back({signal, "", static_cast<int>(i) + 1});
  }
  std::vector<std::string> ignored;
  log.table = read_csv_averaged(path, 1, &ignored, all);
  return log;
}

}  // namespace hrp::diagnosis
