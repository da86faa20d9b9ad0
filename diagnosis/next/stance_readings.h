// SPDX-License-Identifier: BSD-3-Clause
// What a simulated robot on its feet writes, and how well a difference of two such readings shows.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/next/stance_logs.h"
#include "diagnosis/next/stance_trial.h"

namespace hrp::diagnosis {

// [stretch][channel] as in StanceRun::readings, or one number for each channel.
using Readings = std::vector<double>;

class StanceReadings {
 public:
  explicit StanceReadings(const Experiment& experiment);

  size_t channels() const { return noise_.size(); }
  // What the robot of a run writes with these faults of its logs.
  Readings record(const StanceRun& run, const std::vector<LogFault>& faults) const;
  // By channel: inverse standard deviation of a predicted reading, from its noise and from 2 % of its range along the
  // motion. 0 where it is not recorded, or does not change.
  Readings make_weights(const StanceRun& run) const;
  // "/joint_states/knee/effort" and its unit.
  std::string get_signal(size_t channel) const;
  std::string get_unit(size_t channel) const;

 private:
  const Experiment& e_;
  Readings noise_;  // of a mean over a stretch, by channel; 0: not recorded
};

// (a - b) times the weights of their channels, as far as both reach.
Readings subtract(const Readings& a, const Readings& b, const Readings& weights);

}  // namespace hrp::diagnosis
