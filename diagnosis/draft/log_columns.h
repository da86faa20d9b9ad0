// SPDX-License-Identifier: BSD-3-Clause
// A text log as a table of all its columns, whatever they are called.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "diagnosis/data/csv_stream.h"

namespace hrp::diagnosis {

struct LogColumns {
  std::vector<std::string> names;  // of the header; empty when there is none
  size_t count = 0;
  std::vector<std::string> first;  // cells of the first row below them
  Table table;                     // all columns, by number
};

LogColumns read_log_columns(const std::string& path);

}  // namespace hrp::diagnosis
