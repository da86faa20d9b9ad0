// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/csv.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>

#include "common/base/diagnostics.h"

namespace hrp::diagnosis {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

[[noreturn]] void fail(const std::string& file, int line, int column, const std::string& field,
                       const std::string& text) {
  Diagnostic d;
  d.file = file, d.line = line, d.column = column, d.field = field, d.message = text;
  throw InputError(d);
}

std::string read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) fail(path, 0, 0, "", "cannot be read: there is no such file, or no permission");
  const std::streamsize size = file.tellg();
  if (size < 0) fail(path, 0, 0, "", "is not a file");
  std::string text(static_cast<size_t>(size), '\0');
  file.seekg(0);
  file.read(&text[0], size);
  return text;
}

std::string trim(const char* begin, const char* end) {
  while (begin < end && (*begin == ' ' || *begin == '\t' || *begin == '"')) ++begin;
  while (end > begin && (end[-1] == ' ' || end[-1] == '\t' || end[-1] == '\r' || end[-1] == '"')) --end;
  return std::string(begin, end);
}

bool equals_nan(const char* begin, const char* end) {
  const std::string word = trim(begin, end);
  return word.empty() || word == "nan" || word == "NaN" || word == "NAN" || word == "-nan";
}

// One cell; false when it is no number.
bool parse_cell(const char* begin, const char* end, double* value) {
  while (begin < end && (*begin == ' ' || *begin == '\t')) ++begin;
  while (end > begin && (end[-1] == ' ' || end[-1] == '\t' || end[-1] == '\r')) --end;
  if (begin < end && *begin == '+') ++begin;
  const auto result = std::from_chars(begin, end, *value);
  if (result.ec == std::errc() && result.ptr == end && std::isfinite(*value)) return true;
  if (!equals_nan(begin, end)) return false;
  *value = kMissing;
  return true;
}

void read_header(const char* begin, const char* end, Table* table) {
  if (end - begin >= 3 && std::memcmp(begin, "\xEF\xBB\xBF", 3) == 0) begin += 3;  // byte order mark
  for (const char* cell = begin;;) {
    const char* stop = static_cast<const char*>(std::memchr(cell, ',', static_cast<size_t>(end - cell)));
    const char* cell_end = stop ? stop : end;
    table->names.push_back(trim(cell, cell_end));
    if (!stop) break;
    cell = stop + 1;
  }
  table->columns.resize(table->names.size());
  for (size_t i = 0; i < table->names.size(); ++i) {
    for (size_t k = 0; k < i; ++k) {
      if (table->names[i] == table->names[k] && !table->names[i].empty()) {
        fail(table->file, 1, static_cast<int>(i) + 1, table->names[i], "this column stands twice in the header");
      }
    }
  }
}

// False when the row has too few cells.
bool read_row(const char* begin, const char* end, int line, std::vector<double>* row, const Table& table) {
  size_t column = 0;
  for (const char* cell = begin;;) {
    const char* stop = static_cast<const char*>(std::memchr(cell, ',', static_cast<size_t>(end - cell)));
    const char* cell_end = stop ? stop : end;
    if (column >= table.names.size()) {
      fail(table.file, line, static_cast<int>(column) + 1, "",
           "more cells than the header's " + std::to_string(table.names.size()) + " columns");
    }
    if (!parse_cell(cell, cell_end, &(*row)[column])) {
      fail(table.file, line, static_cast<int>(column) + 1, table.names[column],
           "'" + trim(cell, cell_end).substr(0, 40) + "' is no number");
    }
    ++column;
    if (!stop) break;
    cell = stop + 1;
  }
  return column == table.names.size();
}

// Cells without a number between cells with one: a log has none before a signal begins and after it has ended.
void note_empty_cells(const Table& table, std::vector<std::string>* warnings) {
  for (size_t i = 0; i < table.names.size(); ++i) {
    const std::vector<double>& column = table.columns[i];
    size_t first = 0, last = column.size(), count = 0, where = 0;
    while (first < column.size() && std::isnan(column[first])) ++first;
    while (last > first && std::isnan(column[last - 1])) --last;
    for (size_t row = first; row < last; ++row) {
      if (std::isnan(column[row]) && count++ == 0) where = row;
    }
    if (count == 0) continue;
    warnings->push_back(table.file + ":" + std::to_string(table.lines[where]) + ":" + std::to_string(i + 1) + ": warning: " +
                        table.names[i] + ": no number here" +
                        (count > 1 ? " and in " + std::to_string(count - 1) + " more cells" : "") + "; taken as missing");
  }
}

}  // namespace

int Table::find(const std::string& name) const {
  for (size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) return static_cast<int>(i);
  }
  return -1;
}

Table read_csv(const std::string& path, std::vector<std::string>* warnings) {
  const std::string text = read_text(path);
  Table table;
  table.file = path;
  const char* at = text.data();
  const char* const end = at + text.size();
  std::vector<double> row;
  for (int line = 1; at < end; ++line) {
    const char* stop = static_cast<const char*>(std::memchr(at, '\n', static_cast<size_t>(end - at)));
    const char* line_end = stop ? stop : end;
    const char* next = stop ? stop + 1 : end;
    const bool blank = line_end == at || (line_end - at == 1 && *at == '\r') || *at == '#';
    if (!blank && table.names.empty()) {
      read_header(at, line_end, &table);
      row.resize(table.names.size());
    } else if (!blank) {
      if (read_row(at, line_end, line, &row, table)) {
        for (size_t i = 0; i < row.size(); ++i) table.columns[i].push_back(row[i]);
        table.lines.push_back(line);
      } else if (next >= end) {
        warnings->push_back(path + ":" + std::to_string(line) + ": warning: the last line is cut off and was dropped");
      } else {
        fail(path, line, 0, "", "fewer cells than the header's " + std::to_string(table.names.size()) + " columns");
      }
    }
    at = next;
  }
  if (table.names.empty()) fail(path, 0, 0, "", "is empty: expected a header line");
  note_empty_cells(table, warnings);
  if (table.rows() < 2) fail(path, 1, 0, "", "holds no samples");
  return table;
}

}  // namespace hrp::diagnosis
