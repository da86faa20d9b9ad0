// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/stretches.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "diagnosis/data/rounding.h"

namespace hrp::diagnosis {
namespace {

constexpr double kPiece = 10.0;    // [s]
constexpr double kGap = 5.0;       // periods
constexpr double kHeldOut = 1.0 / 3.0;

template <typename Value>
std::vector<Value> cut(const std::vector<Value>& values, size_t begin, size_t end) {
  if (values.empty()) return {};
  return {values.begin() + static_cast<long>(begin), values.begin() + static_cast<long>(end)};
}

Recording cut_recording(const Recording& r, size_t begin, size_t end) {
  Recording out;
  out.spec = r.spec, out.column_of = r.column_of;
  out.spec.name += " (" + number(r.time[begin], 4) + " to " + number(r.time[end - 1], 4) + " s)";
  out.time = cut(r.time, begin, end);
  for (const JointColumns& joint : r.joints) {
    JointColumns own;
    own.command = cut(joint.command, begin, end), own.command_rate = cut(joint.command_rate, begin, end);
    for (int q = 0; q < kQuantities; ++q) own.signal[q] = cut(joint.signal[q], begin, end);
    own.separate_rate = joint.separate_rate;
    out.joints.push_back(std::move(own));
  }
  for (const auto& [name, values] : r.other) out.other[name] = cut(values, begin, end);
  return out;
}

// Rows at which pieces begin, and the end.
std::vector<size_t> find_pieces(const Recording& r) {
  std::vector<size_t> begins{0};
  for (size_t k = 1; k < r.size(); ++k) {
    if (r.time[k] - r.time[begins.back()] >= kPiece) begins.push_back(k);
  }
  begins.push_back(r.size());
  return begins;
}

// Mean square of a joint's changes of position in each piece.
std::vector<double> measure_motion(const JointColumns& joint, const std::vector<double>& time, const std::vector<size_t>& pieces) {
  std::vector<double> motion;
  const std::vector<double>& q = joint.signal[0];
  for (size_t p = 0; p + 1 < pieces.size(); ++p) {
    double sum = 0.0, n = 0.0;
    for (size_t k = pieces[p] + 5; k < pieces[p + 1] && !q.empty(); k += 5) {
      const double v = (q[k] - q[k - 5]) / std::max(1e-9, time[k] - time[k - 5]);
      if (std::isfinite(v)) sum += v * v, n += 1.0;
    }
    motion.push_back(n > 0.0 ? std::sqrt(sum / n) : 0.0);
  }
  return motion;
}

std::vector<double> score_pieces(const Recording& r, const std::vector<size_t>& pieces) {
  std::vector<double> score(pieces.size() - 1, 0.0);
  for (const JointColumns& joint : r.joints) {
    const std::vector<double> motion = measure_motion(joint, r.time, pieces);
    const double most = *std::max_element(motion.begin(), motion.end());
    for (size_t p = 0; p < score.size() && most > 0.0; ++p) score[p] += motion[p] / most;
  }
  return score;
}

void copy_all_but_recordings(const Experiment& from, Experiment* to) {
  to->path = from.path, to->folder = from.folder, to->scenario = from.scenario, to->robot = from.robot, to->keys = from.keys;
  to->joint_noise = from.joint_noise, to->other_noise = from.other_noise, to->warnings = from.warnings;
  to->sample_time = from.sample_time;
}

}  // namespace

size_t find_averaging(double numbers, double rate) {
  const double wanted = std::ceil(numbers / kMostNumbers), most = std::max(1.0, std::floor(rate / kLeastRate));
  return static_cast<size_t>(std::clamp(wanted, 1.0, most));
}

void average_rows(size_t count, Table* table) {
  const int at = table->find("time");
  if (count < 2 || at < 0) return;
  const std::vector<double> time = table->columns[static_cast<size_t>(at)];
  const double period = time.size() > 2 ? (time[2] - time[0]) / 2.0 : 0.0;
  std::vector<size_t> begins;
  for (size_t k = 0; k < time.size(); ++k) {
    if (begins.empty() || k - begins.back() == count || time[k] - time[k - 1] > kGap * period) begins.push_back(k);
  }
  begins.push_back(time.size());
  std::vector<int> lines;
  for (size_t g = 0; g + 1 < begins.size(); ++g) lines.push_back(table->lines[begins[g]]);
  for (std::vector<double>& column : table->columns) {
    for (size_t g = 0; g + 1 < begins.size(); ++g) {
      double sum = 0.0, n = 0.0;
      for (size_t k = begins[g]; k < begins[g + 1]; ++k) {
        if (std::isfinite(column[k])) sum += column[k], n += 1.0;
      }
      column[g] = n > 0.0 ? sum / n : std::numeric_limits<double>::quiet_NaN();
    }
    column.resize(lines.size()), column.shrink_to_fit();
  }
  table->lines = std::move(lines);
}

std::vector<Recording> cut_to_stretches(const Recording& r, double seconds) {
  std::vector<Recording> out;
  if (r.duration() <= std::max(seconds, kPiece)) {
    out.push_back(r);
    return out;
  }
  const std::vector<size_t> pieces = find_pieces(r);
  const std::vector<double> score = score_pieces(r, pieces);
  std::vector<size_t> order(score.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return score[a] > score[b]; });
  order.resize(std::min(order.size(), std::max<size_t>(1, static_cast<size_t>(seconds / kPiece))));
  std::sort(order.begin(), order.end());
  for (size_t i = 0; i < order.size();) {
    size_t last = i;
    while (last + 1 < order.size() && order[last + 1] == order[last] + 1) ++last;
    out.push_back(cut_recording(r, pieces[order[i]], pieces[order[last] + 1]));
    i = last + 1;
  }
  return out;
}

double calc_joint_seconds(const Experiment& e) {
  double sum = 0.0;
  for (const Recording& r : e.recordings) sum += r.duration() * e.num_joints();
  return sum;
}

Experiment make_screened(const Experiment& e, double joint_seconds) {
  Experiment out;
  copy_all_but_recordings(e, &out);
  double length[2] = {0.0, 0.0};  // [s] held out, training
  for (const Recording& r : e.recordings) length[r.spec.train] += r.duration();
  const double seconds = joint_seconds / std::max(1, e.num_joints());
  const double held = length[0] > 0.0 ? kHeldOut * seconds : 0.0;
  const double share[2] = {held / std::max(1e-9, length[0]), (seconds - held) / std::max(1e-9, length[1])};
  for (const Recording& r : e.recordings) {
    for (Recording& piece : cut_to_stretches(r, share[r.spec.train] * r.duration())) out.recordings.push_back(std::move(piece));
  }
  return out;
}

}  // namespace hrp::diagnosis
