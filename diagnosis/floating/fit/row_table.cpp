// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/fit/row_table.h"

#include <algorithm>
#include <cmath>

namespace hrp::diagnosis::floating {

std::map<int, std::vector<double>> split_by_recording(const ChannelRows& rows) {
  std::map<int, std::vector<double>> out;
  for (size_t i = 0; i < rows.rows(); ++i) out[rows.recording[i]].push_back(rows.y[i]);
  return out;
}

int RowTable::add_channel(const ChannelInfo& info, std::vector<int> columns) {
  ChannelRows rows;
  rows.info = info;
  rows.columns = std::move(columns);
  std::vector<int> local(static_cast<size_t>(columns_), -1);
  for (size_t i = 0; i < rows.columns.size(); ++i) local[static_cast<size_t>(rows.columns[i])] = static_cast<int>(i);
  Sum sum;
  sum.x.assign(rows.columns.size(), 0.0);
  channels_.push_back(std::move(rows));
  local_.push_back(std::move(local));
  sums_.push_back(std::move(sum));
  return static_cast<int>(channels_.size()) - 1;
}

void RowTable::begin_cell(const Cell& cell) {
  cell_ = cell;
  for (Sum& s : sums_) {
    s.y = 0;
    s.count = 0;
    std::fill(s.x.begin(), s.x.end(), 0.0);
  }
}

void RowTable::end_cell() {
  for (size_t c = 0; c < sums_.size(); ++c) {
    Sum& s = sums_[c];
    ChannelRows& rows = channels_[c];
    const bool finite =
        std::isfinite(s.y) && std::all_of(s.x.begin(), s.x.end(), [](double v) { return std::isfinite(v); });
    if (2 * s.count < cell_.samples || s.count == 0 || !finite) continue;
    rows.y.push_back(s.y / s.count);
    for (double v : s.x) rows.x.push_back(v / s.count);
    rows.time.push_back(cell_.time);
    rows.recording.push_back(cell_.recording);
    rows.block.push_back(cell_.block);
    rows.roughness.push_back(cell_.roughness);
    rows.phase.push_back(cell_.phase);
    rows.train.push_back(cell_.train);
  }
}

void RowTable::begin_row(int channel, double y, double measured) {
  Sum& s = sums_[static_cast<size_t>(channel)];
  s.y += y;
  ++s.count;
  s.measured += measured;
  s.square += measured * measured;
  s.total += 1;
}

void RowTable::add(int channel, int column, double value) {
  const int at = local_[static_cast<size_t>(channel)][static_cast<size_t>(column)];
  if (at >= 0) sums_[static_cast<size_t>(channel)].x[static_cast<size_t>(at)] += value;
}

void RowTable::finish() {
  for (size_t c = 0; c < sums_.size(); ++c) {
    const Sum& s = sums_[c];
    if (s.total < 2) continue;
    channels_[c].mean = s.measured / s.total;
    channels_[c].scale = std::sqrt(std::max(0.0, s.square / s.total - std::pow(s.measured / s.total, 2)));
  }
}

void RowTable::add_back(const Eigen::VectorXd& by_column) {
  for (ChannelRows& c : channels_) {
    for (size_t i = 0; i < c.rows(); ++i) {
      for (size_t k = 0; k < c.columns.size(); ++k) c.y[i] += c.row(i)[k] * by_column(c.columns[k]);
    }
  }
}

namespace {

ChannelRows merge(const ChannelRows& a, const ChannelRows& b) {
  ChannelRows out;
  out.info = a.info;
  out.columns = a.columns;
  out.scale = a.scale;
  out.mean = a.mean;
  size_t k = 0;
  for (size_t i = 0; i < a.rows(); ++i) {
    while (k < b.rows() &&
           (b.recording[k] < a.recording[i] || (b.recording[k] == a.recording[i] && b.time[k] < a.time[i] - 1e-6)))
      ++k;
    if (k == b.rows()) break;
    if (b.recording[k] != a.recording[i] || b.time[k] > a.time[i] + 1e-6) continue;
    out.y.push_back(0.5 * (a.y[i] + b.y[k]));
    out.noise_y.push_back(0.5 * (a.y[i] - b.y[k]));
    for (size_t c = 0; c < a.columns.size(); ++c) {
      out.x.push_back(0.5 * (a.row(i)[c] + b.row(k)[c]));
      out.noise_x.push_back(0.5 * (a.row(i)[c] - b.row(k)[c]));
    }
    out.time.push_back(a.time[i]);
    out.roughness.push_back(std::max(a.roughness[i], b.roughness[k]));
    out.recording.push_back(a.recording[i]);
    out.block.push_back(a.block[i]);
    out.phase.push_back(a.phase[i]);
    out.train.push_back(a.train[i]);
  }
  return out;
}

}  // namespace

std::vector<ChannelRows> merge_halves(const RowTable& even, const RowTable& odd) {
  std::vector<ChannelRows> out;
  for (size_t c = 0; c < even.channels().size(); ++c) out.push_back(merge(even.channels()[c], odd.channels()[c]));
  return out;
}

}  // namespace hrp::diagnosis::floating
