// SPDX-License-Identifier: BSD-3-Clause
// Recordings in the form that the tool uses: signals by name at the recording's own time stamps.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/base/diagnostics.h"
#include "common/robot/experiment_keys.h"
#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"
#include "diagnosis/data/csv.h"

namespace hrp::diagnosis {

enum class Quantity { kPosition, kVelocity, kEffort };
constexpr int kQuantities = 3;
const char* get_quantity_name(Quantity quantity);

// Columns of one joint; empty if not recorded. NaN where a sample is missing or repeats the last one.
struct JointColumns {
  std::vector<double> command, command_rate;  // without gaps (interpolated)
  std::vector<double> signal[kQuantities];
  bool separate_rate = false;  // the recorded rate of commands is not the derivative of their positions
  bool rough_command = false;  // the rate is the derivative, but positions or stamps are too rough to differentiate
  bool has(Quantity q) const { return !signal[static_cast<int>(q)].empty(); }
};

struct Recording {
  RecordingSpec spec;
  std::vector<double> time;                          // [s] increasing
  std::vector<JointColumns> joints;                  // in the model's order
  std::map<std::string, std::vector<double>> other;  // all other columns by name
  std::map<std::string, int> column_of;              // number of each column in the file, from 1, for messages
  bool has(const std::string& name) const { return other.count(name) > 0; }
  // Where a column's name stands in the file.
  InputPlace find_place(const std::string& column) const {
    const auto at = column_of.find(column);
    return {spec.file, column, 1, at == column_of.end() ? 0 : at->second};
  }
  size_t size() const { return time.size(); }
  double duration() const { return time.back() - time.front(); }
};

// Standard deviation of a signal's noise.
struct Noise {
  double sigma = 0.0;
  bool stated = false;  // in the experiment, else estimated
};

// A scenario with its robot, its recordings and the noise of their signals.
struct Experiment {
  std::string path, folder;
  Scenario scenario;
  RobotDescription robot;
  ExperimentKeys keys;
  std::vector<Recording> recordings;
  std::vector<std::vector<Noise>> joint_noise;  // by joint, by quantity
  std::map<std::string, Noise> other_noise;     // by column
  std::vector<std::string> warnings;            // about clocks, held samples, missing columns, units
  double sample_time = 0.0;                     // [s] median
  int num_joints() const { return robot.tree.num_joints(); }
  std::string signal_name(int joint, Quantity quantity) const;
};

// Loads an experiment. Throws InputError with file, line and column of everything that cannot be used.
Experiment load_experiment(const std::string& path);

}  // namespace hrp::diagnosis
