// SPDX-License-Identifier: BSD-3-Clause
// Robots on their feet, standing or walking, with whatever sensors they have.
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <vector>

#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis {
struct Experiment;
}

namespace hrp::diagnosis::floating {

struct LeggedReport {
  Evidence evidence;
  bool judged = false;                  // something was compared
  bool walks = false;                   // a foot leaves the ground and comes back
  bool raw_counts = false;              // forces are counts of an unknown unit
  std::vector<Eigen::VectorXd> faults;  // of sensors, by column (columns.h), to take out of a log one after another
  Eigen::VectorXd found;                // coefficients of all effects of the best model, by column
  nlohmann::ordered_json series;
};

enum class Robots { kAll, kWalking };     // the others are not judged
enum class Drives { kJudged, kLeftOut };  // their equations
LeggedReport diagnose_legged(const Experiment& experiment, const std::function<void(const std::string&)>& progress,
                             Robots robots = Robots::kAll, Drives drives = Drives::kJudged);

// Why nothing of a floating base can be compared, by recording and column.
std::string find_obstacle(const Experiment& e);

}  // namespace hrp::diagnosis::floating
