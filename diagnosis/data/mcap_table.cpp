// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/diagnostics.h"
#include "common/base/ends_with.h"
#include "common/log/log_table.h"
#include "diagnosis/data/csv.h"

namespace hrp::diagnosis {
namespace {

LogTable read_log(const std::string& path, std::vector<std::string>* warnings) {
  try {
    mcap::Reader reader(path);
    LogTable table = read_log_table(&reader);
    if (!reader.damage().empty()) warnings->push_back(path + ": warning: the log is cut short: " + reader.damage());
    return table;
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& error) {
    refuse_input(path, std::string("cannot be read as a log: ") + error.what());
  }
}

}  // namespace

Table read_mcap(const std::string& path, std::vector<std::string>* warnings) {
  const LogTable log = read_log(path, warnings);
  if (log.rows.size() < 2) refuse_input(path, "holds no samples");
  Table table;
  table.file = path;
  table.names = log.names;
  table.columns.resize(log.names.size());
  for (size_t c = 0; c < log.names.size(); ++c) {
    for (const std::vector<double>& row : log.rows) table.columns[c].push_back(row[c]);
  }
  for (size_t k = 0; k < log.rows.size(); ++k) table.lines.push_back(static_cast<int>(k) + 2);
  return table;
}

Table read_recording_table(const std::string& path, std::vector<std::string>* warnings) {
  return ends_with(path, ".mcap") ? read_mcap(path, warnings) : read_csv(path, warnings);
}

}  // namespace hrp::diagnosis
