// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/csv.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>

#include "common/base/diagnostics.h"
#include "common/base/ends_with.h"
#include "common/base/read_file.h"
#include "diagnosis/data/csv_layout.h"
#include "diagnosis/data/csv_stream.h"
#include "diagnosis/data/gaps.h"
#include "diagnosis/data/repair.h"

namespace hrp::diagnosis {
namespace {

// Reads the rows of a file one by one.
class RowReader {
 public:
  RowReader(const ColumnMap& map, Table* table) : signals_(map.columns), table_(*table) {}

  // Takes one line. False if it is a header or a comment, or has too few cells: then cut() is true.
  bool read(const std::string& text, int line) {
    cut_ = false;
    if (is_blank(text)) {
      if (text.size() > 1) comment_ = text;
      return false;
    }
    if (layout_.cells == 0) {
      layout_ = read_layout(text, comment_, line, signals_, &table_);
      row_.resize(table_.names.size());
      is_text_.resize(row_.size());
      if (layout_.header) return false;
    }
    split_cells(layout_, text, &cells_);
    while (cells_.size() > layout_.cells && trim_cell(cells_.back()).empty())
      cells_.pop_back();  // a separator at its end
    if (cells_.size() > layout_.cells) {
      refuse_input(
          {table_.file, "", line, static_cast<int>(layout_.cells) + 1},
          "more cells than the " + std::to_string(layout_.cells) + " columns of " + first() + hint_at_lists(text));
    }
    if (cells_.size() < layout_.cells && layout_.separator == '\t') split_by_spaces(text);
    cut_ = cells_.size() < layout_.cells;
    for (size_t i = 0; i < row_.size() && !cut_; ++i) row_[i] = read_cell(i, line);
    return !cut_;
  }

  bool cut() const { return cut_; }
  const std::vector<double>& row() const { return row_; }
  size_t count_cells() const { return layout_.cells; }
  std::string first() const { return layout_.header ? "the header" : "the first line"; }

  // Columns that hold words are no signals. Leaves them empty.
  void drop_text(std::vector<std::string>* warnings) const {
    for (size_t i = 0; i < is_text_.size(); ++i) {
      if (!is_text_[i]) continue;
      std::fill(table_.columns[i].begin(), table_.columns[i].end(), kMissing);
      warnings->push_back(table_.file + ": column " + table_.names[i] + " has words and is no signal: it is left out");
    }
  }

 private:
  // A cell for all joints, as pandas writes arrays: "[0.1, 0.2]".
  static std::string hint_at_lists(const std::string& text) {
    return text.find('[') == std::string::npos
               ? ""
               : "; its cells hold lists: scripts/diagnosis/to_text.py FILE writes a column for each value";
  }

  // A line with spaces in place of tabs, as people write them who mend a log by hand.
  void split_by_spaces(const std::string& text) {
    CsvLayout spaces;
    spaces.separator = ' ';
    std::vector<Cell> cells;
    split_cells(spaces, text, &cells);
    if (cells.size() == layout_.cells) cells_ = cells;
  }

  double read_cell(size_t i, int line) {
    const SignalColumn& entry = layout_.signals[i];
    const Cell cell = cells_[layout_.source[i]];
    double value = kMissing;
    if (parse_cell(cell, layout_.separator, &value)) return entry.scale * value + entry.offset;
    if (entry.signal == "time" && parse_stamp(cell, &value)) return value;
    if (entry.signal != "time" && entry.signal.rfind('/', 0) != 0) {
      is_text_[i] = true;
      return kMissing;
    }
    refuse_input({table_.file, entry.signal, line, static_cast<int>(layout_.source[i]) + 1},
                 "'" + trim_cell(cell).substr(0, 40) + "' is no number" + hint_at_lists(trim_cell(cell)));
  }

  const std::vector<SignalColumn> signals_;
  Table& table_;
  CsvLayout layout_;
  std::string comment_;  // the last one before the first line
  std::vector<Cell> cells_;
  std::vector<double> row_;
  std::vector<bool> is_text_;
  bool cut_ = false;
};

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
    warnings->push_back(table.file + ":" + std::to_string(table.lines[where]) + ":" + std::to_string(i + 1) +
                        ": warning: " + table.names[i] + ": no number here" +
                        (count > 1 ? " and in " + std::to_string(count - 1) + " more cells" : "") +
                        "; taken as missing");
  }
}

}  // namespace

int Table::number_of(int column) const {
  const size_t i = static_cast<size_t>(column);
  return i < numbers.size() ? numbers[i] : column + 1;
}

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
  Averager(size_t count, Table* table)
      : count_(count), table_(*table), sum_(table->names.size(), 0.0), n_(sum_.size(), 0.0) {
    const int at = table->find("time");
    time_ = at < 0 ? sum_.size() : static_cast<size_t>(at);
    for (const std::string& name : table->names)
      angle_.push_back(name.rfind("/joint_states/", 0) == 0 && ends_with(name, "/position") ? 1 : 0);
  }

  void add(const std::vector<double>& row, int line) {
    const double t = time_ < row.size() ? row[time_] : 0.0;
    if (taken_ > 0 && step_ > 0.0 && t - last_ > kGapPeriods * step_) close();  // the last step stands for the period
    if (taken_ > 0 && wraps(row)) close();                                      // the mean of pi and -pi is neither
    if (taken_ > 0) step_ = t - last_;
    before_ = row;
    last_ = t;
    if (taken_ == 0) line_ = line;
    for (size_t i = 0; i < row.size(); ++i) {
      if (std::isfinite(row[i])) {
        sum_[i] += row[i];
        n_[i] += 1.0;
      }
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
  bool wraps(const std::vector<double>& row) const {
    for (size_t i = 0; i < row.size(); ++i) {
      if (angle_[i] != 0 && std::abs(row[i] - before_[i]) > kJump) return true;
    }
    return false;
  }

  const size_t count_;
  Table& table_;
  std::vector<double> sum_, n_, before_;
  std::vector<char> angle_;  // by column
  size_t time_ = 0, taken_ = 0;
  double last_ = 0.0, step_ = 0.0;
  int line_ = 0;
};

}  // namespace

CsvShape probe_csv(const std::string& path, const ColumnMap& columns) {
  std::ifstream file = open_text(path);
  Table head;
  head.file = path;
  RowReader rows(columns, &head);
  std::string text;
  std::streamoff bytes = 0;
  for (int line = 1; line < 400 && std::getline(file, text); ++line) {
    if (!rows.read(text, line)) continue;
    for (size_t i = 0; i < rows.row().size(); ++i) head.columns[i].push_back(rows.row()[i]);
    head.lines.push_back(line);
    bytes += static_cast<std::streamoff>(text.size()) + 1;
  }
  CsvShape shape;
  shape.columns = static_cast<double>(head.names.size());
  file.clear();
  file.seekg(0, std::ios::end);
  if (bytes > 0)
    shape.rows = static_cast<double>(file.tellg()) * static_cast<double>(head.rows()) / static_cast<double>(bytes);
  const int time = head.find("time");
  if (time < 0 || head.rows() < 8) return shape;
  const std::vector<double>& t = head.columns[static_cast<size_t>(time)];
  if (t.back() > t.front()) shape.rate = static_cast<double>(t.size() - 1) / (t.back() - t.front());
  return shape;
}

Table read_csv(const std::string& path, std::vector<std::string>* warnings) {
  return read_csv_averaged(path, 1, warnings);
}

// Reads line by line, because a recording of twenty minutes may not fit into memory.
Table read_csv_averaged(const std::string& path, size_t count, std::vector<std::string>* warnings,
                        const ColumnMap& columns) {
  std::ifstream file = open_text(path);
  Table table;
  table.file = path;
  RowReader rows(columns, &table);
  std::string text;
  std::unique_ptr<Averager> means;
  for (int line = 1; std::getline(file, text); ++line) {
    const bool whole = rows.read(text, line);
    if (!means && rows.count_cells() > 0) means = std::make_unique<Averager>(count, &table);
    if (whole) {
      means->add(rows.row(), line);
    } else if (rows.cut() && file.peek() == std::ifstream::traits_type::eof()) {
      warnings->push_back(path + ":" + std::to_string(line) + ": warning: the last line is cut off and was dropped");
    } else if (rows.cut()) {
      refuse_input({path, "", line, 0},
                   "fewer cells than the " + std::to_string(rows.count_cells()) + " columns of " + rows.first());
    }
  }
  check_end(file, path);
  if (!means) refuse_input(path, "is empty: expected a header line");
  means->close();
  rows.drop_text(warnings);
  note_empty_cells(table, warnings);
  if (table.rows() < 2) refuse_input({path, "", 1, 0}, "holds no samples");
  return table;
}

}  // namespace hrp::diagnosis
