// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <stdexcept>

#include "common/base/diagnostics.h"
#include "common/base/exact_number.h"
#include "common/base/suggest.h"
#include "common/log/log_table.h"
#include "common/plot/svg_plot.h"
#include "servers/console/log_tool/commands.h"
#include "servers/console/log_tool/log_file.h"

namespace hrp {
namespace {

PlotSeries find_column(const LogTable& table, const std::string& name, const std::string& file) {
  const auto found = std::find(table.names.begin(), table.names.end(), name);
  if (found == table.names.end()) {
    refuse_input(file, "no signal '" + name + "'" + suggest(name, table.names));
  }
  const auto column = static_cast<size_t>(found - table.names.begin());
  PlotSeries series{name, {}, {}};
  for (const std::vector<double>& row : table.rows) {
    series.x.push_back(row[0]);
    series.y.push_back(column < row.size() ? row[column] : std::nan(""));
  }
  return series;
}

// "contact_forces:pairs[0].total.force.z"
PlotSeries find_field(const std::string& file, const std::string& signal, size_t colon) {
  LogFile log(file);
  const LogTopicType& topic = log.find_topic(signal.substr(0, colon));
  if (topic.type == nullptr) throw std::runtime_error(file + ": the type of '" + topic.topic + "' cannot be read");
  const FieldPath path(*topic.type, signal.substr(colon + 1));
  PlotSeries series{signal + (path.unit().empty() ? "" : " [" + path.unit() + "]"), {}, {}};
  log.reader().read_messages(
      [&](const mcap::Message& message) {
        series.x.push_back(static_cast<double>(message.log_time) * 1e-9);
        series.y.push_back(find_number(*topic.type, get_bytes(message), path).value_or(std::nan("")));
        return true;
      },
      {topic.topic});
  return series;
}

}  // namespace

int write_csv(const std::string& file, const std::string& out) {
  mcap::Reader log(file);
  const LogTable table = read_log_table(&log);
  std::ofstream csv(out, std::ios::binary);
  std::string line;
  for (const std::string& name : table.names) line += (line.empty() ? "" : ",") + name;
  csv << line << "\n";
  for (const std::vector<double>& row : table.rows) {
    line.clear();
    for (size_t i = 0; i < row.size(); ++i) {
      if (i > 0) line += ',';
      if (!std::isnan(row[i])) line += format_exact(row[i]);
    }
    csv << line << "\n";
  }
  csv.close();
  if (!csv) throw std::runtime_error(out + ": cannot be written");
  std::printf("%s: %zu rows, %zu columns\n", out.c_str(), table.rows.size(), table.names.size());
  return say_damage(log);
}

int write_plot(const std::string& file, const std::vector<std::string>& signals, const std::string& out) {
  if (signals.empty()) {
    write_contact_force_plot(file, out);
    return 0;
  }
  Plot plot{file, "time [s]", signals.size() == 1 ? signals[0] : "value", {}};
  mcap::Reader log(file);
  LogTable table;
  for (const std::string& signal : signals) {
    const size_t colon = signal.find(':');
    if (colon == std::string::npos && table.names.empty()) table = read_log_table(&log);
    plot.series.push_back(colon == std::string::npos ? find_column(table, signal, file)
                                                     : find_field(file, signal, colon));
  }
  write_svg(plot, out);
  return 0;
}

}  // namespace hrp
