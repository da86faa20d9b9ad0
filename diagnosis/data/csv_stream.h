// SPDX-License-Identifier: BSD-3-Clause
// Reads text recordings that are too large for memory, or that others wrote: `columns` say where the signals are.
#pragma once

#include <string>
#include <vector>

#include "common/robot/column_map.h"
#include "diagnosis/data/csv.h"

namespace hrp::diagnosis {

struct CsvShape {
  double rows = 0.0, columns = 0.0;  // rows: by the size of the file and of its first lines
  double rate = 0.0;                 // [Hz] of its first samples; 0: not known
};
CsvShape probe_csv(const std::string& path, const ColumnMap& columns = {});

// Like read_csv(), with each `count` consecutive samples averaged while reading. A gap ends a group.
Table read_csv_averaged(const std::string& path, size_t count, std::vector<std::string>* warnings,
                        const ColumnMap& columns = {});

}  // namespace hrp::diagnosis
