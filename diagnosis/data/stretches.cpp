// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/data/stretches.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "common/base/rounding.h"
#include "diagnosis/data/gaps.h"

namespace hrp::diagnosis {
namespace {

constexpr double kPiece = 10.0;         // [s]
constexpr double kHeldOut = 1.0 / 3.0;  // of the time that is used, for held-out recordings

// Joints times seconds: half a minute of one core in torque space, minutes in simulation.
constexpr double kSearched = 2400.0;
// [s] of robots on their feet: a minute of one core with 13 joints at 200 Hz. Every hypothesis is evaluated at every
// sample, and balance and soles need the same time whatever the number of joints.
constexpr double kSearchedOnFeet = 120.0;

template <typename Value>
std::vector<Value> cut(const std::vector<Value>& values, size_t begin, size_t end) {
  if (values.empty()) return {};
  return {values.begin() + static_cast<long>(begin), values.begin() + static_cast<long>(end)};
}

// First rows of the pieces, and the end.
std::vector<size_t> find_pieces(const Recording& r) {
  std::vector<size_t> begins{0};
  for (size_t k = 1; k < r.size(); ++k) {
    if (r.time[k] - r.time[begins.back()] >= kPiece) begins.push_back(k);
  }
  begins.push_back(r.size());
  return begins;
}

// Rms speed of a joint in each piece.
std::vector<double> measure_motion(const JointColumns& joint, const std::vector<double>& time,
                                   const std::vector<size_t>& pieces) {
  std::vector<double> motion;
  const std::vector<double>& q = joint.signal[0];
  for (size_t p = 0; p + 1 < pieces.size(); ++p) {
    double sum = 0.0, n = 0.0;
    for (size_t k = pieces[p] + 5; k < pieces[p + 1] && !q.empty(); k += 5) {
      const double v = (q[k] - q[k - 5]) / std::max(1e-9, time[k] - time[k - 5]);
      if (std::isfinite(v)) {
        sum += v * v;
        n += 1.0;
      }
    }
    motion.push_back(n > 0.0 ? std::sqrt(sum / n) : 0.0);
  }
  return motion;
}

// A piece of a recording, and its score: each joint's speed there relative to its fastest piece.
struct Piece {
  size_t recording = 0, begin = 0, end = 0;  // rows
  double score = 0.0, seconds = 0.0;
  size_t rank = 0;  // within its file
};

std::vector<Piece> list_pieces(const std::vector<const Recording*>& recordings) {
  std::vector<Piece> all;
  std::vector<std::vector<double>> motion;  // by joint, by piece
  for (size_t i = 0; i < recordings.size(); ++i) {
    const Recording& r = *recordings[i];
    const std::vector<size_t> begins = find_pieces(r);
    for (size_t p = 0; p + 1 < begins.size(); ++p)
      all.push_back({i, begins[p], begins[p + 1], 0.0, r.time[begins[p + 1] - 1] - r.time[begins[p]], 0});
    motion.resize(r.joints.size());
    for (size_t j = 0; j < r.joints.size(); ++j) {
      const std::vector<double> own = measure_motion(r.joints[j], r.time, begins);
      motion[j].insert(motion[j].end(), own.begin(), own.end());
    }
  }
  for (const std::vector<double>& joint : motion) {
    const double most = joint.empty() ? 0.0 : *std::max_element(joint.begin(), joint.end());
    for (size_t p = 0; p < joint.size() && most > 0.0; ++p) all[p].score += joint[p] / most;
  }
  return all;
}

// Chooses the best piece of every file, then the second best of every file, and so on, up to `seconds`.
std::vector<Piece> choose_pieces(std::vector<Piece> pieces, const std::vector<const Recording*>& recordings,
                                 double seconds) {
  std::stable_sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.score > b.score; });
  std::map<std::string, size_t> count;
  for (Piece& p : pieces) p.rank = count[recordings[p.recording]->spec.file]++;
  std::stable_sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.rank < b.rank; });
  std::vector<Piece> chosen;
  double sum = 0.0;
  for (const Piece& p : pieces) {
    if (sum + 0.5 * p.seconds > seconds && !chosen.empty()) break;
    chosen.push_back(p);
    sum += p.seconds;
  }
  std::sort(chosen.begin(), chosen.end(), [](const Piece& a, const Piece& b) {
    return a.recording != b.recording ? a.recording < b.recording : a.begin < b.begin;
  });
  return chosen;
}

// Chosen pieces as recordings; adjacent ones are joined.
std::vector<Recording> cut_pieces(const std::vector<const Recording*>& recordings, const std::vector<Piece>& chosen) {
  std::vector<Recording> out;
  for (size_t i = 0; i < chosen.size();) {
    size_t last = i;
    while (last + 1 < chosen.size() && chosen[last + 1].recording == chosen[i].recording &&
           chosen[last + 1].begin == chosen[last].end)
      ++last;
    const Recording& r = *recordings[chosen[i].recording];
    const bool whole = chosen[i].begin == 0 && chosen[last].end == r.size();
    out.push_back(whole ? r : cut_recording(r, chosen[i].begin, chosen[last].end));
    i = last + 1;
  }
  return out;
}

std::vector<Recording> cut_all(const std::vector<const Recording*>& recordings, double seconds) {
  if (recordings.empty()) return {};
  return cut_pieces(recordings, choose_pieces(list_pieces(recordings), recordings, seconds));
}

// Rows behind gaps.
std::vector<size_t> find_ends_of_gaps(const std::vector<double>& time) {
  const double gap = find_cutting_gap(find_period(time));
  std::vector<size_t> ends;
  for (size_t k = 1; k < time.size(); ++k) {
    if (time[k] - time[k - 1] > gap) ends.push_back(k);
  }
  return ends;
}

void copy_all_but_recordings(const Experiment& from, Experiment* to) {
  to->path = from.path;
  to->folder = from.folder;
  to->scenario = from.scenario;
  to->robot = from.robot;
  to->keys = from.keys;
  to->joint_noise = from.joint_noise;
  to->other_noise = from.other_noise;
  to->warnings = from.warnings;
  to->sample_time = from.sample_time;
}

}  // namespace

Recording cut_recording(const Recording& r, size_t begin, size_t end) {
  Recording out;
  out.spec = r.spec;
  out.column_of = r.column_of;
  out.spec.name = r.spec.name.substr(0, r.spec.name.find(" (")) + " (" + number(r.time[begin], 4) + " to " +
                  number(r.time[end - 1], 4) + " s)";
  out.time = cut(r.time, begin, end);
  for (const JointColumns& joint : r.joints) {
    JointColumns own;
    own.command = cut(joint.command, begin, end);
    own.command_rate = cut(joint.command_rate, begin, end);
    for (int q = 0; q < kQuantities; ++q) own.signal[q] = cut(joint.signal[q], begin, end);
    own.separate_rate = joint.separate_rate;
    own.rough_command = joint.rough_command;
    out.joints.push_back(std::move(own));
  }
  for (const auto& [name, values] : r.other) out.other[name] = cut(values, begin, end);
  return out;
}

std::vector<Recording> cut_at_gaps(const Recording& r, std::vector<std::string>* warnings) {
  std::vector<size_t> begins = find_ends_of_gaps(r.time);
  if (begins.empty()) return {r};
  const size_t gaps = begins.size(), first = begins[0];
  begins.insert(begins.begin(), 0);
  begins.push_back(r.size());
  std::vector<Recording> parts;
  double lost = 0.0;
  for (size_t i = 0; i + 1 < begins.size(); ++i) {
    const double seconds = r.time[begins[i + 1] - 1] - r.time[begins[i]];
    if (seconds >= kShortestPart) {
      parts.push_back(cut_recording(r, begins[i], begins[i + 1]));
    } else {
      lost += seconds;
    }
  }
  if (parts.empty()) return {r};
  warnings->push_back(r.spec.name + ": " + (gaps == 1 ? "a gap" : std::to_string(gaps) + " gaps, the first") +
                      " without samples from " + number(r.time[first - 1], 5) + " to " + number(r.time[first], 5) +
                      " s: nothing is carried across" +
                      (lost > 0.0 ? "; " + number(lost, 3) + " s in parts shorter than a second are left out" : ""));
  return parts;
}

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
    if (begins.empty() || k - begins.back() == count || time[k] - time[k - 1] > kGapPeriods * period)
      begins.push_back(k);
  }
  begins.push_back(time.size());
  std::vector<int> lines;
  for (size_t g = 0; g + 1 < begins.size(); ++g) lines.push_back(table->lines[begins[g]]);
  for (std::vector<double>& column : table->columns) {
    for (size_t g = 0; g + 1 < begins.size(); ++g) {
      double sum = 0.0, n = 0.0;
      for (size_t k = begins[g]; k < begins[g + 1]; ++k) {
        if (std::isfinite(column[k])) {
          sum += column[k];
          n += 1.0;
        }
      }
      column[g] = n > 0.0 ? sum / n : std::numeric_limits<double>::quiet_NaN();
    }
    column.resize(lines.size());
    column.shrink_to_fit();
  }
  table->lines = std::move(lines);
}

std::vector<Recording> cut_to_stretches(const Recording& r, double seconds) {
  if (r.duration() <= seconds) return {r};
  return cut_all({&r}, seconds);
}

double calc_searched(const Experiment& e) {
  if (e.num_joints() == 0) return std::numeric_limits<double>::infinity();  // a throw is short
  if (e.scenario.floating_base) return kSearchedOnFeet * e.num_joints();
  return e.scenario.drive == "motion" ? std::numeric_limits<double>::infinity() : kSearched;
}

double calc_joint_seconds(const Experiment& e) {
  double sum = 0.0;
  for (const Recording& r : e.recordings) sum += r.duration() * e.num_joints();
  return sum;
}

double calc_joint_samples(const Experiment& e) {
  double sum = 0.0;
  for (const Recording& r : e.recordings) sum += static_cast<double>(r.size()) * e.num_joints();
  return sum;
}

Experiment make_screened(const Experiment& e, double joint_seconds) {
  std::vector<int> all(e.recordings.size());
  std::iota(all.begin(), all.end(), 0);
  return make_screened(e, joint_seconds, all);
}

Experiment make_screened(const Experiment& e, double joint_seconds, const std::vector<int>& recordings) {
  Experiment out;
  copy_all_but_recordings(e, &out);
  std::vector<const Recording*> train, held;
  for (int i : recordings) {
    const Recording& r = e.recordings[static_cast<size_t>(i)];
    (r.spec.train ? train : held).push_back(&r);
  }
  const double seconds = joint_seconds / std::max(1, e.num_joints());
  const double of_held = held.empty() ? 0.0 : train.empty() ? seconds : kHeldOut * seconds;
  out.recordings = cut_all(train, seconds - of_held);
  for (Recording& piece : cut_all(held, of_held)) out.recordings.push_back(std::move(piece));
  return out;
}

}  // namespace hrp::diagnosis
