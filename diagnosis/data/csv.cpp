// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>
#include <set>
#include <sstream>

#include "common/base/diagnostics.h"
#include "common/base/read_file.h"
#include "diagnosis/data/csv_stream.h"
#include "diagnosis/data/gaps.h"

namespace hrp::diagnosis {
namespace {

std::string trim(const char* begin, const char* end) {
  while (begin < end && (*begin == ' ' || *begin == '\t' || *begin == '"')) ++begin;
  while (end > begin && (end[-1] == ' ' || end[-1] == '\t' || end[-1] == '\r' || end[-1] == '"')) --end;
  return std::string(begin, end);
}

bool equals_nan(const char* begin, const char* end) {
  const std::string word = trim(begin, end);
  return word.empty() || word == "nan" || word == "NaN" || word == "NAN" || word == "-nan";
}

// Parses one cell; returns false if it is no number.
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

// Throws for files that are no text, such as compressed files and UTF-16, and for separators other than commas.
void check_header(const char* begin, const char* end, const Table& table) {
  const auto is_control = [](unsigned char c) { return c < 0x20 && c != '\t'; };
  const char* stop = end > begin && end[-1] == '\r' ? end - 1 : end;
  const char* bad = std::find_if(begin, stop, is_control);
  if (bad != stop && *bad == '\r')
    refuse_input({table.file, "", 1, 0}, "its lines end with CR alone: expected LF or CR LF");
  if (bad != stop) {
    refuse_input({table.file, "", 1, 0}, "is no text: byte " + std::to_string(static_cast<unsigned char>(*bad)) +
                                             " at place " + std::to_string(bad - begin + 1) +
                                             " of its header; expected comma-separated values in UTF-8");
  }
  const char* other = table.names.size() > 1 ? stop : std::find_if(begin, stop, [](char c) { return c == ';' || c == '\t'; });
  if (other != stop) {
    refuse_input({table.file, "", 1, 0}, std::string("its header has ") + (*other == ';' ? "semicolons" : "tabs") +
                                             " and no comma: expected commas between cells");
  }
}

void check_names(const Table& table) {
  double value = 0.0;
  const std::string& first = table.names[0];
  if (parse_cell(first.data(), first.data() + first.size(), &value) && !std::isnan(value))
    refuse_input({table.file, "", 1, 1},
                 "'" + first + "' stands where a header is expected: the names of the columns, such as time");
  std::set<std::string> seen;
  for (size_t i = 0; i < table.names.size(); ++i) {
    if (table.names[i].empty() || seen.insert(table.names[i]).second) continue;
    refuse_input({table.file, table.names[i], 1, static_cast<int>(i) + 1}, "this column stands twice in the header");
  }
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
  check_header(begin, end, *table);
  check_names(*table);
}

// Returns false if the row has too few cells.
bool read_row(const char* begin, const char* end, int line, std::vector<double>* row, const Table& table) {
  size_t column = 0;
  for (const char* cell = begin;;) {
    const char* stop = static_cast<const char*>(std::memchr(cell, ',', static_cast<size_t>(end - cell)));
    const char* cell_end = stop ? stop : end;
    if (column >= table.names.size()) {
      refuse_input({table.file, "", line, static_cast<int>(column) + 1},
                   "more cells than the header's " + std::to_string(table.names.size()) + " columns");
    }
    if (!parse_cell(cell, cell_end, &(*row)[column])) {
      refuse_input({table.file, table.names[column], line, static_cast<int>(column) + 1},
                   "'" + trim(cell, cell_end).substr(0, 40) + "' is no number");
    }
    ++column;
    if (!stop) break;
    cell = stop + 1;
  }
  return column == table.names.size();
}

// Warns of empty cells between numbers. Before a signal starts and after it ends, empty cells are normal.
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

namespace {

// Adds rows to the table as means of `count` consecutive ones.
class Averager {
 public:
  Averager(size_t count, Table* table) : count_(count), table_(*table), sum_(table->names.size(), 0.0), n_(sum_.size(), 0.0) {
    const int at = table->find("time");
    time_ = at < 0 ? sum_.size() : static_cast<size_t>(at);
  }

  void add(const std::vector<double>& row, int line) {
    const double t = time_ < row.size() ? row[time_] : 0.0;
    if (taken_ > 0 && step_ > 0.0 && t - last_ > kGapPeriods * step_) close();  // the last step stands for the period
    if (taken_ > 0) step_ = t - last_;
    last_ = t;
    if (taken_ == 0) line_ = line;
    for (size_t i = 0; i < row.size(); ++i) {
      if (std::isfinite(row[i])) sum_[i] += row[i], n_[i] += 1.0;
    }
    if (++taken_ == count_) close();
  }

  void close() {
    if (taken_ == 0) return;
    for (size_t i = 0; i < sum_.size(); ++i) {
      table_.columns[i].push_back(n_[i] > 0.0 ? sum_[i] / n_[i] : kMissing);
      sum_[i] = n_[i] = 0.0;
    }
    table_.lines.push_back(line_);
    taken_ = 0;
  }

 private:
  const size_t count_;
  Table& table_;
  std::vector<double> sum_, n_;
  size_t time_ = 0, taken_ = 0;
  double last_ = 0.0, step_ = 0.0;
  int line_ = 0;
};

}  // namespace

CsvShape probe_csv(const std::string& path) {
  std::ifstream file = open_input(path);
  Table head;
  head.file = path;
  std::string text;
  std::vector<double> row;
  std::streamoff bytes = 0;
  for (int line = 1; line < 400 && std::getline(file, text); ++line) {
    if (text.empty() || text[0] == '#' || text == "\r") continue;
    if (head.names.empty()) {
      read_header(text.data(), text.data() + text.size(), &head);
      row.resize(head.names.size());
    } else if (read_row(text.data(), text.data() + text.size(), line, &row, head)) {
      for (size_t i = 0; i < row.size(); ++i) head.columns[i].push_back(row[i]);
      head.lines.push_back(line), bytes += static_cast<std::streamoff>(text.size()) + 1;
    }
  }
  CsvShape shape;
  shape.columns = static_cast<double>(head.names.size());
  file.clear();
  file.seekg(0, std::ios::end);
  if (bytes > 0) shape.rows = static_cast<double>(file.tellg()) * static_cast<double>(head.rows()) / static_cast<double>(bytes);
  const int time = head.find("time");
  if (time < 0 || head.rows() < 8) return shape;
  const std::vector<double>& t = head.columns[static_cast<size_t>(time)];
  if (t.back() > t.front()) shape.rate = static_cast<double>(t.size() - 1) / (t.back() - t.front());
  return shape;
}

Table read_csv(const std::string& path, std::vector<std::string>* warnings) { return read_csv_averaged(path, 1, warnings); }

// Reads line by line, because a recording of twenty minutes may not fit into memory.
Table read_csv_averaged(const std::string& path, size_t count, std::vector<std::string>* warnings) {
  std::ifstream file = open_input(path);
  Table table;
  table.file = path;
  std::string text;
  std::vector<double> row;
  std::unique_ptr<Averager> rows;
  for (int line = 1; std::getline(file, text); ++line) {
    const char *begin = text.data(), *end = begin + text.size();
    const bool blank = text.empty() || text == "\r" || text[0] == '#';
    if (blank) continue;
    if (table.names.empty()) {
      read_header(begin, end, &table);
      row.resize(table.names.size());
      rows = std::make_unique<Averager>(count, &table);
    } else if (read_row(begin, end, line, &row, table)) {
      rows->add(row, line);
    } else if (file.peek() == std::ifstream::traits_type::eof()) {
      warnings->push_back(path + ":" + std::to_string(line) + ": warning: the last line is cut off and was dropped");
    } else {
      refuse_input({path, "", line, 0},
                   "fewer cells than the header's " + std::to_string(table.names.size()) + " columns");
    }
  }
  check_end(file, path);
  if (table.names.empty()) refuse_input(path, "is empty: expected a header line");
  rows->close();
  note_empty_cells(table, warnings);
  if (table.rows() < 2) refuse_input({path, "", 1, 0}, "holds no samples");
  return table;
}

}  // namespace hrp::diagnosis
