// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/base/trim.h"

namespace hrp {

// The cells of a line of CSV, trimmed. No quotes: a comma always ends a cell. An empty line is one empty cell.
inline std::vector<std::string> split_cells(const std::string& line) {
  std::vector<std::string> cells;
  size_t at = 0;
  while (true) {
    const size_t comma = line.find(',', at);
    cells.push_back(trim(line.substr(at, comma == std::string::npos ? comma : comma - at)));
    if (comma == std::string::npos) return cells;
    at = comma + 1;
  }
}

}  // namespace hrp
