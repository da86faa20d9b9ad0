// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/csv_layout.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <set>

#include "common/base/diagnostics.h"
#include "common/base/read_file.h"
#include "common/base/suggest.h"

namespace hrp::diagnosis {
namespace {

constexpr const char* kHowToMap =
    "say under 'columns' of the experiment which column holds which signal (docs/text_recordings.md)";

bool equals_nan(Cell cell) {
  const std::string word = trim_cell(cell);
  static const std::set<std::string> words{"",   "nan", "NaN",  "NAN",  "-nan", "NA",
                                           "na", "N/A", "null", "NULL", "None", "none"};
  return words.count(word) > 0;
}

// A line with a semicolon or a tab has it between its cells, because numbers and names have none.
char find_separator(const std::string& line) {
  for (const char c : {';', '\t', ','}) {
    if (line.find(c) != std::string::npos) return c;
  }
  return line.find_first_of(' ', line.find_first_not_of(' ')) == std::string::npos ? ',' : ' ';
}

struct Format {
  std::string start, is, remedy;
};

// What people have in place of text.
const std::vector<Format>& list_formats() {
  static const std::string convert = "scripts/diagnosis/to_text.py FILE writes it as text";
  static const std::vector<Format> formats{
      {"\x93NUMPY", "is a NumPy array", convert},
      {"PK\x03\x04", "is a zip archive, as NumPy's .npz", convert + " if it is one; export a spreadsheet as CSV"},
      {"\x89HDF", "is HDF5", convert},
      {"MATLAB ", "is a MATLAB file", convert},
      {"#ROSBAG", "is a bag of ROS 1", "its name must end with .bag"},
      {"SQLite format 3", "is an sqlite3 database", "the name of a bag must end with .db3"},
      {"\x89MCAP", "is MCAP", "its name must end with .mcap"},
      {"\x1f\x8b", "is packed with gzip", "gunzip it"},
      {"BZh", "is packed with bzip2", "bunzip2 it"},
      {"\xfd"
       "7zXZ",
       "is packed with xz", "unxz it"},
      {"PAR1", "is Parquet", "write it as CSV"},
      {"{", "is JSON", convert},
      {"[{", "is JSON", convert},
      {"[[", "is JSON", convert},
      {"[\n", "is JSON", convert}};
  return formats;
}

// Throws for files that are no text, such as compressed files and UTF-16.
void check_text(const std::string& line, const Table& table) {
  const auto is_control = [](unsigned char c) { return c < 0x20 && c != '\t'; };
  const auto end = !line.empty() && line.back() == '\r' ? line.end() - 1 : line.end();
  const auto bad = std::find_if(line.begin(), end, is_control);
  if (bad == end) return;
  if (*bad == '\r') refuse_input({table.file, "", 1, 0}, "its lines end with CR alone: expected LF or CR LF");
  refuse_input({table.file, "", 1, 0}, "is no text: byte " + std::to_string(static_cast<unsigned char>(*bad)) +
                                           " at place " + std::to_string(bad - line.begin() + 1) +
                                           " of its header; expected comma-separated values in UTF-8");
}

// True if the line has a number and nothing but numbers.
bool are_numbers(const std::vector<Cell>& cells, char separator) {
  bool any = false;
  for (const Cell& cell : cells) {
    double value = 0.0;
    if (!parse_cell(cell, separator, &value) && !parse_stamp(cell, &value)) return false;
    any = any || std::isfinite(value);
  }
  return any;
}

void check_names(const std::vector<std::string>& names, int line, const Table& table) {
  std::set<std::string> seen;
  for (size_t i = 0; i < names.size(); ++i) {
    if (names[i].empty() || seen.insert(names[i]).second) continue;
    refuse_input({table.file, names[i], line, static_cast<int>(i) + 1}, "this column stands twice in the header");
  }
}

// Which cell of a line has the signal. `names` are those of the header; empty without one.
size_t find_source(const SignalColumn& entry, const std::vector<std::string>& names, size_t cells,
                   const InputPlace& place) {
  const std::string by = entry.name.empty() ? std::to_string(entry.number) : "'" + entry.name + "'";
  const auto refuse = [&](const std::string& why) {
    refuse_input(place, "is column " + by + " by 'columns' of the experiment: " + why);
  };
  if (entry.name.empty()) {
    if (static_cast<size_t>(entry.number) > cells)
      refuse("expected at most " + std::to_string(cells) + ", the number of the file's columns");
    return static_cast<size_t>(entry.number) - 1;
  }
  if (names.empty()) refuse("the file has no header, expected its number, from 1");
  const auto at = std::find(names.begin(), names.end(), entry.name);
  if (at == names.end()) refuse("the header has no such name" + suggest(entry.name, names));
  if (std::find(at + 1, names.end(), entry.name) != names.end())
    refuse("this name stands twice in the header, expected its number, from 1");
  return static_cast<size_t>(at - names.begin());
}

// Each column is the signal that its name says. `first`: the first cell.
void take_header(const std::string& first, int line, CsvLayout* layout, Table* table) {
  const std::vector<std::string>& names = layout->names;
  if (names.empty())
    refuse_input(
        {table->file, "", line, 1},
        "'" + first + "' stands where a header is expected: the names of the columns, such as time; or " + kHowToMap);
  check_names(names, line, *table);
  const bool timed = std::find(names.begin(), names.end(), "time") != names.end();
  for (size_t i = 0; i < names.size(); ++i) {
    layout->signals.emplace_back().signal =
        !timed && names[i] == "__time" ? "time" : names[i];  // as PlotJuggler has it
    layout->source.push_back(i);
  }
}

}  // namespace

std::ifstream open_text(const std::string& path) {
  std::ifstream file = open_input(path);
  char start[16] = {};
  file.read(start, sizeof start);
  for (const Format& format : list_formats()) {
    if (std::memcmp(start, format.start.data(), format.start.size()) == 0)
      refuse_input(path, format.is + ", expected comma-separated values: " + format.remedy);
  }
  file.clear();
  file.seekg(std::memcmp(start, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0);  // byte order mark
  return file;
}

std::string trim_cell(Cell cell) {
  auto [begin, end] = cell;
  while (begin < end && (*begin == ' ' || *begin == '\t' || *begin == '"')) ++begin;
  while (end > begin && (end[-1] == ' ' || end[-1] == '\t' || end[-1] == '\r' || end[-1] == '"')) --end;
  return std::string(begin, end);
}

bool is_blank(const std::string& line) { return line.empty() || line == "\r" || line[0] == '#' || line[0] == '%'; }

void split_cells(const CsvLayout& layout, const std::string& line, std::vector<Cell>* cells) {
  cells->clear();
  const char *begin = line.data(), *end = begin + line.size();
  if (end > begin && end[-1] == '\r') --end;
  if (layout.separator == ' ') {
    const auto is_space = [](char c) { return c == ' ' || c == '\t'; };
    for (const char* at = begin; at < end;) {
      at = std::find_if_not(at, end, is_space);
      const char* stop = std::find_if(at, end, is_space);
      if (stop > at) cells->emplace_back(at, stop);
      at = stop;
    }
    return;
  }
  for (const char* at = begin;;) {
    const char* stop = static_cast<const char*>(std::memchr(at, layout.separator, static_cast<size_t>(end - at)));
    cells->emplace_back(at, stop ? stop : end);
    if (!stop) return;
    at = stop + 1;
  }
}

namespace {

bool has_number(const std::vector<Cell>& cells, char separator) {
  return std::any_of(cells.begin(), cells.end(), [&](const Cell& cell) {
    double value = 0.0;
    return parse_cell(cell, separator, &value) && std::isfinite(value);
  });
}

// The names in a comment before lines of numbers, if it has one for most cells: words between the same separators.
// Words between spaces may be a sentence, so then all cells need one.
std::vector<std::string> read_comment(const CsvLayout& layout, const std::string& comment) {
  const std::string text = comment.substr(std::min(comment.size(), comment.find_first_not_of("#% ")));
  std::vector<Cell> cells;
  split_cells(layout, text, &cells);
  std::vector<std::string> names;
  for (const Cell& cell : cells) {
    names.push_back(trim_cell(cell));
    while (!names.back().empty() && names.back().back() == ',') names.back().pop_back();
  }
  const bool enough = layout.separator == ' ' ? names.size() == layout.cells : 2 * names.size() > layout.cells;
  if (!enough || names.size() > layout.cells || are_numbers(cells, layout.separator)) return {};
  names.resize(layout.cells);
  return names;
}

// A comment that names all cells of a line with words and numbers, as `rostopic echo -p` writes it. A header has no
// numbers.
bool is_named_row(const CsvLayout& layout, const std::vector<Cell>& cells, const std::string& comment) {
  const std::vector<std::string> names = read_comment(layout, comment);
  if (names.empty() || std::any_of(names.begin(), names.end(), [](const std::string& name) { return name.empty(); }))
    return false;
  return has_number(cells, layout.separator);
}

}  // namespace

CsvLayout read_layout(const std::string& line, const std::string& comment, int number,
                      const std::vector<SignalColumn>& signals, Table* table) {
  CsvLayout layout;
  check_text(line, *table);
  layout.separator = find_separator(line);
  std::vector<Cell> cells;
  split_cells(layout, line, &cells);
  if (layout.separator == '\t' &&
      !are_numbers(cells, '\t')) {  // tabs between lines of numbers with spaces, as of `paste`
    CsvLayout spaces = layout;
    spaces.separator = ' ';
    split_cells(spaces, line, &cells);
    if (are_numbers(cells, ' '))
      layout = spaces;
    else
      split_cells(layout, line, &cells);
  }
  layout.cells = cells.size();
  layout.header = !are_numbers(cells, layout.separator) && !is_named_row(layout, cells, comment);
  for (const Cell& cell : cells) {
    if (layout.header) layout.names.push_back(trim_cell(cell));
  }
  if (!layout.header) layout.names = read_comment(layout, comment);
  if (signals.empty()) take_header(trim_cell(cells[0]), number, &layout, table);
  for (const SignalColumn& entry : signals) {
    layout.source.push_back(find_source(entry, layout.names, cells.size(), {table->file, entry.signal, number}));
    layout.signals.push_back(entry);
  }
  for (size_t i = 0; i < layout.signals.size(); ++i) {
    table->names.push_back(layout.signals[i].signal);
    table->numbers.push_back(static_cast<int>(layout.source[i]) + 1);
  }
  table->columns.resize(table->names.size());
  return layout;
}

bool parse_cell(Cell cell, char separator, double* value) {
  auto [begin, end] = cell;
  const auto is_around = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '"'; };
  while (begin < end && is_around(*begin)) ++begin;
  while (end > begin && is_around(end[-1])) --end;
  if (begin < end && *begin == '+') ++begin;
  auto result = std::from_chars(begin, end, *value);
  std::string text;
  if (separator != ',' && result.ptr < end && *result.ptr == ',') {
    text.assign(begin, end);
    text[static_cast<size_t>(result.ptr - begin)] = '.';
    begin = text.data();
    end = begin + text.size();
    result = std::from_chars(begin, end, *value);
  }
  if (result.ec == std::errc() && result.ptr == end && std::isfinite(*value)) return true;
  if (!equals_nan(cell)) return false;
  *value = kMissing;
  return true;
}

bool parse_stamp(Cell cell, double* value) {
  const std::string text = trim_cell(cell);
  std::tm date{};
  date.tm_year = 70;
  date.tm_mon = date.tm_mday = 1;
  int read = 0, seconds_at = 0;
  if (std::sscanf(text.c_str(), "%4d-%2d-%2d%*1[T ]%n", &date.tm_year, &date.tm_mon, &date.tm_mday, &read) == 3 &&
      read > 0) {
    date.tm_year -= 1900;
  } else {
    read = 0;
    date.tm_year = 70;
    date.tm_mon = date.tm_mday = 1;
  }
  date.tm_mon -= 1;
  if (std::sscanf(text.c_str() + read, "%2d:%2d:%n", &date.tm_hour, &date.tm_min, &seconds_at) != 2 || seconds_at == 0)
    return false;
  const char *begin = text.c_str() + read + seconds_at, *end = text.c_str() + text.size();
  double seconds = 0.0;
  const auto result = std::from_chars(begin, end, seconds);
  // What may follow is a zone, the same in all rows: only differences of stamps count.
  const bool zone = result.ptr == end || *result.ptr == 'Z' || *result.ptr == '+' || *result.ptr == '-';
  if (result.ec != std::errc() || !zone || !(seconds >= 0.0 && seconds < 61.0)) return false;
  *value = static_cast<double>(timegm(&date)) + seconds;
  return true;
}

}  // namespace hrp::diagnosis
