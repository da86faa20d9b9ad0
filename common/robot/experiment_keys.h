// SPDX-License-Identifier: BSD-3-Clause
// The keys of an experiment folder that a simulation has no use for: recordings and what is known about them.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace hrp {

struct RecordingSpec {
  std::string file;                         // absolute
  std::string name;                         // as written
  bool train = true;                        // role train, else validate
  std::vector<std::string> feet_attached;   // links that stand fast (bolted or held)
  std::vector<std::string> unknown_force;   // joints or links pushed by somebody
  int line = 0;
};

struct ExperimentKeys {
  std::vector<RecordingSpec> recordings;
  std::map<std::string, double> noise;      // standard deviations by quantity ("position") or by signal name
  std::map<std::string, std::string> wrench_frame;  // "world" or "link" by sensor
};

// From the text of an experiment file. Throws InputError with file, line, column.
ExperimentKeys parse_experiment_keys(const std::string& text, const std::string& path);

}  // namespace hrp
