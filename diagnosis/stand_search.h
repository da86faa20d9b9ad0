// SPDX-License-Identifier: BSD-3-Clause
// The diagnosis of a standing robot by the equations of stand_rows.h: which effects, alone or together, make efforts,
// wrenches, attitude and angles agree.
#pragma once

#include <map>

#include "diagnosis/search.h"
#include "diagnosis/stand_rows.h"

namespace hrp::diagnosis {

// One effect that can be tried, with the columns of its parameters.
struct StandCandidate {
  std::string effect;                        // name
  std::string where_kind, where;             // "joint", "link", "foot", "sensor", "ground"
  std::vector<int> columns;
  // Parameters (vectors keep their axes together) and their standard deviations from the coefficients.
  struct Value {
    std::string name, unit;
    std::vector<double> value, std;
  };
  std::function<std::vector<Value>(const Eigen::VectorXd& x, const Eigen::MatrixXd& covariance)> explain;
  std::string phrase;
};

struct StandOutcome {
  std::vector<StandCandidate> chosen;
  std::vector<std::vector<StandCandidate::Value>> values;
  std::vector<std::string> row_names, row_signals;      // by row of a sample
  std::vector<double> sigma;
  // Root mean square of each row over its sigma, before and after, by recording.
  std::vector<std::vector<double>> before, after;
  double train_before = 0, train_after = 0, validate_before = 0, validate_after = 0, worst_after = 0;
  bool mismatch = false, explained = false;
  struct Rival {
    std::string effect, where_kind, where;
    double validate = 0.0;
  };
  std::vector<Rival> rivals;
  std::vector<Rival> twins;
  std::vector<std::vector<double>> times;               // by recording
  std::vector<Eigen::MatrixXd> residual_before, residual_after;   // by recording: sample x row, whitened
};

StandOutcome search_standing(const Problem& problem, const Progress& progress);

}  // namespace hrp::diagnosis
