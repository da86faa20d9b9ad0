// SPDX-License-Identifier: BSD-3-Clause
// From the equations of rows.h to a verdict.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "diagnosis/held_feet/rows.h"

namespace hrp::diagnosis::held_feet {

struct RowFit {
  RowHypothesis hypothesis;
  std::vector<std::vector<double>> std;  // from scores summed over half-second blocks
  std::vector<double> chi2;              // by block of all recordings, whitened
  double train = 0.0, held = 0.0;        // root mean squares, noise = 1
};

struct RowTrial {
  RowEffect added;
  RowFit fit;
  double gain = 0.0;  // of chi2, fitted blocks
  bool accepted = false;
  std::string why;
};

struct RowOutcome {
  RowFit nominal, chosen, baseline;  // baseline: viscous, Coulomb and rotor inertia at every driven joint
  std::vector<RowTrial> trials;
  bool mismatch = false, explained = false, partly = false;
  std::string held;  // what the fit is judged on
};

using RowProgress = std::function<void(const std::string&)>;
RowOutcome search_rows(const RowProblem& problem, const RowProgress& progress);

// Parameters fitted to the blocks in `use` (by block; blocks are numbered over the recordings).
RowFit fit_rows(const RowProblem& problem, const RowHypothesis& start, const std::vector<char>& use);
// The recording of every block, and its first and last sample.
struct RowBlock {
  size_t recording = 0, first = 0, end = 0;
};
std::vector<RowBlock> list_blocks(const RowProblem& problem);

nlohmann::ordered_json make_row_report(const RowProblem& problem, const RowOutcome& outcome);
nlohmann::ordered_json make_row_series(const RowProblem& problem, const RowOutcome& outcome);

// Fixed bases whose feet are attached or touch the ground, with measured foot forces. False when these recordings are
// not that, with the reason.
bool diagnose_held_feet(const Experiment& experiment, const RowProgress& progress, nlohmann::ordered_json* report,
                       nlohmann::ordered_json* series, std::string* why);

}  // namespace hrp::diagnosis::held_feet
