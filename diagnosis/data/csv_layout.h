// SPDX-License-Identifier: BSD-3-Clause
// How a text recording is written: separators, decimal marks, a header or none, and which cells hold which signals.
#pragma once

#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "common/robot/column_map.h"
#include "diagnosis/data/csv.h"

namespace hrp::diagnosis {

using Cell = std::pair<const char*, const char*>;  // its begin and end in a line

struct CsvLayout {
  char separator = ',';               // ',', ';', '\t', or ' ' for any number of spaces and tabs
  bool header = true;                 // the first line has names
  std::vector<std::string> names;     // of the cells, by the header or by a comment before the first line; empty: none
  size_t cells = 0;                   // in a line
  std::vector<SignalColumn> signals;  // of the table's columns, in its order
  std::vector<size_t> source;         // by column: its cell
};

// A text file, from its beginning, or behind its byte order mark. Throws InputError for what cannot be opened, and for
// other kinds of files, with what to do.
std::ifstream open_text(const std::string& path);

// True for lines that say nothing: empty ones, and comments that begin with # or %.
bool is_blank(const std::string& line);

// Sets the layout and the names of the table's columns by the file's first line. `comment`: the one before it, or "".
// NumPy and MATLAB write their headers as comments. Throws InputError if it is no text, or if the columns of `signals`
// are not there.
CsvLayout read_layout(const std::string& line, const std::string& comment, int number,
                      const std::vector<SignalColumn>& signals, Table* table);

void split_cells(const CsvLayout& layout, const std::string& line, std::vector<Cell>* cells);

// Parses one cell: a number, nothing, or "nan"; with a decimal comma where commas do not separate. False: none of
// these.
bool parse_cell(Cell cell, char separator, double* value);

// Parses a date and time, or a time of day [s]: "2026-11-28T14:36:19.250Z".
bool parse_stamp(Cell cell, double* value);

std::string trim_cell(Cell cell);  // without spaces and quotes around it

}  // namespace hrp::diagnosis
