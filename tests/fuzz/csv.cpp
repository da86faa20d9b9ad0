// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/diagnostics.h"
#include "servers/viewer/csv_table.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const hrp::test::MemoryFile file(data, size);
  try {
    const hrp::CsvTable table = hrp::read_csv_table(file.path());
    for (const auto& column : table.columns) {
      if (column.size() != table.columns[0].size()) std::abort();  // every row has every column
    }
  } catch (const hrp::InputError&) {
  }
  return 0;
}
