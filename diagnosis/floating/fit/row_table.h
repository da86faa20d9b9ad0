// SPDX-License-Identifier: BSD-3-Clause
// Equations as rows: what sensors say less what the model says, and how that would change with each effect. Rows are
// means over cells of a few samples, so that errors of neighbours are nearly independent.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "diagnosis/floating/equations/equation.h"

namespace hrp::diagnosis::floating {

// One equation: where it points, and the recorded signal nearest to it.
struct ChannelInfo {
  Equation equation;
  std::string signal, unit;  // "/joint_states/knee/effort", "N m"
  std::string place, name;   // "joint", "knee"; "foot", "sensor", "link"
  double error = 0;          // [unit] to which the equation is exact at best, where that is known
};

struct ChannelRows {
  ChannelInfo info;
  std::vector<int> columns;  // of the effects' columns, those that may change this equation
  std::vector<double> y;     // by row
  std::vector<double> x;     // row-major, rows x columns
  // Half the difference of the two halves' rows: noise alone. Empty until merge_halves().
  std::vector<double> noise_y, noise_x;
  std::vector<double> time;                  // [s]
  std::vector<double> roughness;             // mean square of Clip::roughness over the cell
  std::vector<int> recording, block, phase;  // blocks are numbered over all recordings
  std::vector<char> train;
  double mean = 0;   // of the measured quantity
  double scale = 0;  // spread of the measured quantity: what a mismatch is a share of
  size_t rows() const { return y.size(); }
  const double* row(size_t i) const { return x.data() + i * columns.size(); }
  const double* noise_row(size_t i) const { return noise_x.data() + i * columns.size(); }
  // Place of an effect's column in a row; -1: it does not change this equation.
  int find_column(int column) const {
    const auto at = std::find(columns.begin(), columns.end(), column);
    return at == columns.end() ? -1 : static_cast<int>(at - columns.begin());
  }
};

class RowTable {
 public:
  explicit RowTable(int columns) : columns_(columns) {}
  // `columns` in any order, without repetition.
  int add_channel(const ChannelInfo& info, std::vector<int> columns);

  struct Cell {
    double time = 0;
    int recording = 0, block = 0, phase = 0;
    bool train = true;
    int samples = 1;  // of a full cell
    double roughness = 1;
  };
  void begin_cell(const Cell& cell);
  void end_cell();  // keeps the channels that had at least half of the samples

  // A sample of one channel: begin, then any number of terms.
  void begin_row(int channel, double y, double measured);
  void add(int channel, int column, double value);

  const std::vector<ChannelRows>& channels() const { return channels_; }
  int num_columns() const { return columns_; }
  void finish();  // spreads
  // Adds what effects of these sizes, by column, predict: rows that were made without them then have them again.
  void add_back(const Eigen::VectorXd& by_column);

 private:
  struct Sum {
    double y = 0;
    int count = 0;
    std::vector<double> x;
    double measured = 0, square = 0, total = 0;
  };
  int columns_;
  Cell cell_;
  std::vector<ChannelRows> channels_;
  std::vector<std::vector<int>> local_;  // by channel, by column: place in the row, -1: none
  std::vector<Sum> sums_;
};

// What is left of an equation, by recording.
std::map<int, std::vector<double>> split_by_recording(const ChannelRows& rows);

// The rows that both halves have: their means, and half their differences.
std::vector<ChannelRows> merge_halves(const RowTable& even, const RowTable& odd);

}  // namespace hrp::diagnosis::floating
