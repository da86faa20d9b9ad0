// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/effort_dropouts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "common/base/rounding.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/measurement/torque/flags.h"

namespace hrp::diagnosis {
namespace {

constexpr long kColumns = 5;                         // tau, a, v, direction, constant
constexpr long kFewest = kRowsPerColumn * kColumns;  // samples of the law

const std::vector<double>& get_effort(const Experiment& e, size_t recording, int joint) {
  return e.recordings[recording].joints[static_cast<size_t>(joint)].signal[static_cast<size_t>(Quantity::kEffort)];
}

struct Run {
  size_t begin = 0, end = 0;  // samples
  size_t size() const { return end - begin; }
};

// All stretches of equal samples, of one sample, too.
std::vector<Run> list_runs(const std::vector<double>& x) {
  std::vector<Run> runs;
  for (size_t k = 0; k < x.size(); ++k) {
    if (!runs.empty() && x[runs.back().begin] == x[k])
      runs.back().end = k + 1;
    else
      runs.push_back({k, k + 1});
  }
  return runs;
}

// Length of the run to which the middle sample belongs, runs in the order of their length.
double find_usual_length(std::vector<Run> runs, size_t samples) {
  std::sort(runs.begin(), runs.end(), [](const Run& a, const Run& b) { return a.size() < b.size(); });
  size_t before = 0;
  for (const Run& run : runs) {
    before += run.size();
    if (2 * before >= samples) return static_cast<double>(run.size());
  }
  return static_cast<double>(samples);
}

// Jump [N m] from or to a run, the larger one; 0 at both ends of a recording.
double find_jump(const std::vector<double>& x, const Run& run) {
  const double in = run.begin > 0 ? std::abs(x[run.begin] - x[run.begin - 1]) : 0.0;
  const double out = run.end < x.size() ? std::abs(x[run.end] - x[run.end - 1]) : 0.0;
  return std::max(std::isfinite(in) ? in : 0.0, std::isfinite(out) ? out : 0.0);
}

// Runs that are longer than usual, begin or end with a jump, and are not at the drive's limit.
std::vector<Dropout> list_candidates(const Experiment& e, size_t recording, int joint) {
  const std::vector<double>& x = get_effort(e, recording, joint);
  std::vector<double> finite, steps;
  for (size_t k = 0; k < x.size(); ++k) {
    if (std::isfinite(x[k])) finite.push_back(x[k]);
    if (k > 0 && std::abs(x[k] - x[k - 1]) > 0.0) steps.push_back(std::abs(x[k] - x[k - 1]));
  }
  std::vector<Dropout> list;
  if (steps.empty()) return list;
  const double spread = find_quantile(finite, 1.0 - kMinor) - find_quantile(finite, kMinor),
               step = find_quantile(steps, 0.0);
  double largest = 0.0;
  for (double y : finite) largest = std::max(largest, std::abs(y));
  const std::vector<Run> runs = list_runs(x);
  // Of three equal samples two neighbours may agree by chance; logs that hold their values have longer ones as a rule.
  const double least = kSeveralTimes * find_usual_length(runs, x.size());
  for (const Run& run : runs) {
    const double value = x[run.begin];
    if (!std::isfinite(value) || static_cast<double>(run.size()) < least || std::abs(value) > (1.0 - kTrace) * largest)
      continue;
    if (find_jump(x, run) > std::max(kDetail * spread, kClearlyMore * step))
      list.push_back({recording, joint, run.begin, run.end, value});
  }
  return list;
}

// Whether `time` [s] is within a dropout of the recording, or `reach` [s] around it; null if not.
const Dropout* find_at(const Experiment& e, const std::vector<Dropout>& list, size_t recording, double time,
                       double reach) {
  for (const Dropout& d : list) {
    const std::vector<double>& t = e.recordings[recording].time;
    if (d.recording == recording && time > t[d.begin] - reach && time < t[d.end - 1] + reach) return &d;
  }
  return nullptr;
}

// Samples of one joint in use: regressors and effort [N m], outside of all candidates and within each. All are filtered
// alike, so a constant that is true agrees with the motion at its ends, too.
struct JointRows {
  std::vector<Eigen::Matrix<double, kColumns, 1>> outside, inside;
  std::vector<double> effort, effort_inside;
  std::vector<const Dropout*> which;  // inside
};

JointRows collect(const TorqueData& data, int joint, const std::vector<Dropout>& candidates) {
  JointRows rows;
  for (const TorqueRecording& r : data.recordings) {
    const Eigen::VectorXd direction = data.calc_direction(r, joint);
    for (long k = 0; k < r.kept(); ++k) {
      if (!r.use(k, joint)) continue;
      const long i = r.full_row(k);
      Eigen::Matrix<double, kColumns, 1> x;
      x << r.tau(i, joint), r.a(i, joint), r.v(i, joint), direction[k], 1.0;
      const Dropout* in = find_at(*data.experiment, candidates, r.index, r.time(k), 0.0);
      if (in) {
        rows.inside.push_back(x);
        rows.effort_inside.push_back(r.effort(i, joint));
        rows.which.push_back(in);
      } else if (!find_at(*data.experiment, candidates, r.index, r.time(k), kFilterReach / data.cutoff)) {
        rows.outside.push_back(x);
        rows.effort.push_back(r.effort(i, joint));
      }
    }
  }
  return rows;
}

// Stretches of one value; those whose value is there once are one group: a log that holds its last value.
struct Group {
  std::vector<const Dropout*> runs;
  double square = 0.0, rows = 0.0;  // of what the law misses [(N m)^2]
};

// Values that are no efforts: the law of the other samples misses them. Stretches are the independent samples. `left`:
// what the law misses elsewhere, `effort`: variance of the effort [(N m)^2]. A detail of it may come from the steps at
// the ends.
bool is_none(const Group& group, double left, double effort, size_t groups) {
  if (group.rows == 0.0 || left <= 0.0) return false;
  const double missed = group.square / group.rows;
  if (missed < kDetail * effort) return false;
  const double ratio = missed / left, runs = static_cast<double>(group.runs.size());
  const double nats = 0.5 * runs * (ratio - 1.0 - std::log(ratio));
  return ratio > kAboveNoise * kAboveNoise && nats > kOdds + std::log(static_cast<double>(groups));
}

std::vector<Dropout> choose(const TorqueData& data, int joint, const std::vector<Dropout>& candidates) {
  const JointRows rows = collect(data, joint, candidates);
  const long n = static_cast<long>(rows.outside.size());
  if (n < kFewest || rows.inside.empty()) return {};
  Eigen::MatrixXd X(n, kColumns);
  for (long k = 0; k < n; ++k) X.row(k) = rows.outside[static_cast<size_t>(k)];
  const Eigen::Map<const Eigen::VectorXd> y(rows.effort.data(), n);
  const Eigen::VectorXd theta = X.completeOrthogonalDecomposition().solve(y);
  const double left = (y - X * theta).squaredNorm() / static_cast<double>(n),
               spread = (y.array() - y.mean()).square().mean();
  const auto key = [&](const Dropout& d) {
    const auto same = std::count_if(candidates.begin(), candidates.end(),
                                    [&](const Dropout& other) { return other.value == d.value; });
    return same > 1 || d.value == 0.0 ? d.value : std::numeric_limits<double>::infinity();
  };
  std::map<double, Group> groups;
  for (const Dropout& d : candidates) groups[key(d)].runs.push_back(&d);
  for (size_t k = 0; k < rows.inside.size(); ++k) {
    Group& group = groups[key(*rows.which[k])];
    group.square += std::pow(rows.effort_inside[k] - rows.inside[k].dot(theta), 2);
    group.rows += 1.0;
  }
  std::vector<Dropout> found;
  for (const auto& [value, group] : groups) {
    for (const Dropout* d : group.runs) {
      if (is_none(group, left, spread, groups.size())) found.push_back(*d);
    }
  }
  return found;
}

std::string describe(const Experiment& e, const std::vector<Dropout>& list) {
  const Recording& r = e.recordings[list[0].recording];
  std::string stretches;
  double samples = 0.0;
  for (size_t i = 0; i < list.size(); ++i) {
    samples += static_cast<double>(list[i].end - list[i].begin);
    if (i < kMostInSentence)
      stretches +=
          (i > 0 ? ", " : " from ") + number(r.time[list[i].begin], 5) + " to " + number(r.time[list[i].end - 1], 5);
  }
  if (list.size() > kMostInSentence)
    stretches += " and " + std::to_string(list.size() - kMostInSentence) + " more times";
  const bool zero = std::all_of(list.begin(), list.end(), [](const Dropout& d) { return d.value == 0.0; });
  return r.spec.name + ": " + e.signal_name(list[0].joint, Quantity::kEffort) + " is exactly " +
         (zero ? "0" : "constant") + stretches + " s, " + number(100.0 * samples / static_cast<double>(r.size()), 2) +
         " % of the samples, while the motion takes another effort: lost by the log, or drives off with brakes on. "
         "Left out";
}

}  // namespace

std::vector<Dropout> find_dropouts(const Experiment& e) {
  std::vector<std::vector<Dropout>> candidates(static_cast<size_t>(e.num_joints()));
  bool any = false;
  for (int j = 0; j < e.num_joints(); ++j) {
    for (size_t r = 0; r < e.recordings.size() && e.robot.tree.joint(j).actuated; ++r) {
      for (const Dropout& d : list_candidates(e, r, j)) {
        candidates[static_cast<size_t>(j)].push_back(d);
        any = true;
      }
    }
  }
  std::vector<Dropout> found;
  if (!any) return found;
  const TorqueData data = make_torque_data(e);
  for (int j = 0; j < e.num_joints(); ++j) {
    const std::vector<Dropout>& own = candidates[static_cast<size_t>(j)];
    if (own.empty() || data.source[static_cast<size_t>(j)] != EffortSource::kRecorded) continue;
    for (const Dropout& d : choose(data, j, own)) found.push_back(d);
  }
  std::stable_sort(found.begin(), found.end(), [](const Dropout& a, const Dropout& b) {
    return a.recording != b.recording ? a.recording < b.recording
           : a.joint != b.joint       ? a.joint < b.joint
                                      : a.begin < b.begin;
  });
  return found;
}

Experiment leave_out_dropouts(Experiment e, const std::vector<Dropout>& dropouts) {
  std::vector<Dropout> same;
  for (size_t i = 0; i < dropouts.size(); ++i) {
    const Dropout& d = dropouts[i];
    same.push_back(d);
    const bool last =
        i + 1 == dropouts.size() || dropouts[i + 1].recording != d.recording || dropouts[i + 1].joint != d.joint;
    if (last) {
      e.warnings.push_back(describe(e, same));
      same.clear();
    }
    std::vector<double>& effort =
        e.recordings[d.recording].joints[static_cast<size_t>(d.joint)].signal[static_cast<size_t>(Quantity::kEffort)];
    std::fill(effort.begin() + static_cast<long>(d.begin), effort.begin() + static_cast<long>(d.end),
              std::numeric_limits<double>::quiet_NaN());
  }
  return e;
}

}  // namespace hrp::diagnosis
