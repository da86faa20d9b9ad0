// SPDX-License-Identifier: BSD-3-Clause
#include <set>

#include "common/base/diagnostics.h"
#include "common/base/ends_with.h"
#include "common/base/split_cells.h"
#include "common/base/trim.h"
#include "controller/motion/motion.h"
#include "controller/motion/motion_text.h"

namespace hrp {
namespace {

struct Column {
  size_t index = 0;  // in the file
  std::string joint;
};

// "/joint_commands/KNEE/position" -> "KNEE"; "KNEE" stays; other topics -> "".
std::string read_joint_name(const std::string& word) {
  const std::string prefix = "/joint_commands/", suffix = "/position";
  if (word.find('/') == std::string::npos) return word;
  const bool command =
      word.rfind(prefix, 0) == 0 && word.size() > prefix.size() + suffix.size() && ends_with(word, suffix);
  return command ? word.substr(prefix.size(), word.size() - prefix.size() - suffix.size()) : "";
}

std::vector<Column> read_header(const std::string& line, const std::string& path, int number, size_t* width) {
  const std::vector<std::string> words = split_cells(line);
  *width = words.size();
  if (words[0] != "time") {
    refuse_input({path, "", number},
                 "the first column is '" + words[0] + "', expected a header 'time,JOINT,JOINT,...'");
  }
  std::vector<Column> columns;
  std::set<std::string> seen;
  for (size_t i = 1; i < words.size(); ++i) {
    if (words[i].empty()) refuse_input({path, "", number}, "column " + std::to_string(i + 1) + " has no name");
    const std::string joint = read_joint_name(words[i]);
    if (joint.empty()) continue;
    if (!seen.insert(joint).second) refuse_input({path, "", number}, "joint '" + joint + "' has two columns");
    columns.push_back({i, joint});
  }
  if (columns.empty()) refuse_input({path, "", number}, "has no column of joint positions");
  return columns;
}

std::vector<double> read_row(const std::string& line, const std::string& path, int number, size_t width) {
  std::vector<double> values;
  const char* at = line.data();
  const char* end = at + line.size();
  while (true) {
    double value = 0.0;
    const char* start = at;
    if (!read_number(&at, end, &value)) {
      refuse_input({path, "", number}, "column " + std::to_string(values.size() + 1) + " is " + show_word(start, end) +
                                           ", expected a finite number");
    }
    values.push_back(value);
    while (at < end && (*at == ' ' || *at == '\t' || *at == '\r')) ++at;
    if (at == end) break;
    if (*at != ',')
      refuse_input({path, "", number}, "has " + show_word(at, end) + " behind a number, expected a comma");
    ++at;
  }
  if (values.size() != width) {
    refuse_input({path, "", number},
                 "has " + std::to_string(values.size()) + " columns, expected " + std::to_string(width));
  }
  return values;
}

}  // namespace

Motion parse_csv_motion(const std::string& text, const std::string& path) {
  Motion motion;
  std::vector<Column> columns;
  std::vector<double> values;  // frame after frame
  size_t width = 0;
  int number = 0;
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    at = end + 1;
    ++number;
    if (trim(line).empty() || trim(line)[0] == '#') continue;
    if (columns.empty()) {
      columns = read_header(line, path, number, &width);
      continue;
    }
    const std::vector<double> row = read_row(line, path, number, width);
    if (!motion.times.empty() && row[0] <= motion.times.back()) {
      refuse_input({path, "", number}, "time " + std::to_string(row[0]) + " s does not rise");
    }
    motion.times.push_back(row[0]);
    for (const Column& column : columns) values.push_back(row[column.index]);
  }
  if (motion.times.empty()) refuse_input({path, "", number}, "has no frames");
  const double start = motion.times.front();
  for (double& time : motion.times) time -= start;
  for (const Column& column : columns) motion.joints.push_back(column.joint);
  motion.positions =
      Eigen::Map<const Eigen::MatrixXd>(values.data(), Eigen::Index(columns.size()), Eigen::Index(motion.times.size()));
  return motion;
}

}  // namespace hrp
