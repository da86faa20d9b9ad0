// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/report/series.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/report/json.h"
#include "diagnosis/search/subtrees.h"

namespace hrp::diagnosis {
namespace {

Json make_map(const Problem& problem, int r, const std::vector<double>& before, const std::vector<double>& after) {
  const Recording& recording = problem.experiment->recordings[static_cast<size_t>(r)];
  const double step = std::max(recording.duration() / 150.0, 2.0 * problem.experiment->sample_time);
  const size_t width = problem.weights.size(), bins = static_cast<size_t>(recording.duration() / step) + 1;
  Json rows = Json::array();
  for (size_t c = 0; c < width; ++c) {
    const std::vector<double>& column = recording.joints[c / kQuantities].signal[c % kQuantities];
    if (column.empty()) continue;
    std::vector<double> a(bins, 0.0), b(bins, 0.0), n(bins, 0.0);
    for (size_t k = 0; k < recording.size(); ++k) {
      if (!std::isfinite(column[k])) continue;
      const size_t bin = std::min(bins - 1, static_cast<size_t>((recording.time[k] - recording.time[0]) / step));
      a[bin] += before[k * width + c] * before[k * width + c];
      b[bin] += after[k * width + c] * after[k * width + c];
      n[bin] += 1.0;
    }
    Json ja = Json::array(), jb = Json::array();
    for (size_t i = 0; i < bins; ++i) {
      ja.push_back(round_to(std::sqrt(a[i] / std::max(1.0, n[i])), 3));
      jb.push_back(round_to(std::sqrt(b[i] / std::max(1.0, n[i])), 3));
    }
    rows.push_back({{"signal", c}, {"before", ja}, {"after", jb}});
  }
  return {{"start", recording.time[0]}, {"step", step}, {"rows", rows}};
}

Json make_traces(const Problem& problem, int r, const Outcome& outcome, const std::vector<double>& before,
                 const std::vector<double>& after) {
  const Recording& recording = problem.experiment->recordings[static_cast<size_t>(r)];
  const size_t width = problem.weights.size();
  std::vector<std::pair<double, size_t>> order;
  for (size_t c = 0; c < width; ++c) order.push_back({-outcome.nominal.validate.rms(c), c});
  std::sort(order.begin(), order.end());
  Json traces = Json::array();
  const size_t skip = recording.size() / 600 + 1;
  for (size_t i = 0; i < std::min<size_t>(6, order.size()); ++i) {
    const size_t c = order[i].second;
    const auto& column = recording.joints[c / kQuantities].signal[c % kQuantities];
    if (column.empty()) continue;
    Json time = Json::array(), recorded = Json::array(), jb = Json::array(), ja = Json::array();
    for (size_t k = problem.smooth[static_cast<size_t>(r)].judged; k < recording.size(); k += skip) {
      if (!std::isfinite(column[k])) continue;
      const double weight = get_weight(problem, static_cast<size_t>(r), k, c);
      time.push_back(round_to(recording.time[k], 6));
      recorded.push_back(round_to(column[k], 6));
      jb.push_back(round_to(column[k] - before[k * width + c] / weight, 6));
      ja.push_back(round_to(column[k] - after[k * width + c] / weight, 6));
    }
    traces.push_back({{"signal", c}, {"time", time}, {"recorded", recorded}, {"before", jb}, {"after", ja}});
  }
  return traces;
}

Json make_rivals(const Problem& problem, const Outcome& outcome) {
  Json list = Json::array();
  for (const Trial& t : outcome.rivals) {
    if (t.hypothesis.empty() || t.rms > 1e6) continue;
    const bool chosen =
        get_label(*problem.experiment, t.hypothesis) == get_label(*problem.experiment, outcome.chosen.hypothesis) &&
        (outcome.explained || outcome.partly);
    Json where =
        t.hypothesis.size() == 1 ? make_where(*problem.experiment, t.hypothesis[0]) : Json{{"joint", "several"}};
    const std::string name =
        t.hypothesis.size() == 1 ? get_effect(t.hypothesis[0].id).name : get_label(*problem.experiment, t.hypothesis);
    list.push_back(
        {{"effect", name},
         {"where", where},
         {"probability", round_to(t.probability, 3)},
         {"validate_score", round_to(t.rms, 4)},
         {"complexity", t.hypothesis.size()},
         {"chosen", chosen},
         {"why", chosen ? "explains the recordings it was not fitted to best"
                        : "leaves " + number(t.rms, 3) + " times the noise, " + number(t.worst, 3) + " in its worst " +
                              (t.refined ? "signal" : "joint (along the recorded paths)")}});
  }
  return list;
}

}  // namespace

Json make_series(const Problem& problem, const Outcome& outcome, const Trial& after) {
  const Experiment& e = *problem.experiment;
  const Problem start_nominal = start_as(problem, outcome.nominal), start_after = start_as(problem, after);
  Json series{{"schema", 1}, {"experiment", e.robot.tree.name}, {"robot", e.robot.tree.name}};
  Json signals = Json::array(), recordings = Json::array();
  for (size_t c = 0; c < problem.weights.size(); ++c) {
    const Noise& noise = e.joint_noise[c / kQuantities][c % kQuantities];
    const bool turns = e.robot.tree.joint(static_cast<int>(c / kQuantities)).kind == JointKind::kRevolute;
    const char* const units[2][3] = {{"m", "m/s", "N"}, {"rad", "rad/s", "N m"}};
    signals.push_back({{"name", signal_name(e, c)},
                       {"unit", units[turns][c % kQuantities]},
                       {"noise", round_to(noise.sigma, 4)},
                       {"noise_source", noise.stated ? "stated" : "estimated"}});
  }
  for (size_t r = 0; r < e.recordings.size(); ++r) {
    std::vector<double> before, fitted;
    const Recording& recording = e.recordings[r];
    Json entry{{"file", recording.spec.name},
               {"role", recording.spec.train ? "train" : "validate"},
               {"start", recording.time.front()},
               {"end", recording.time.back()}};
    if (calc_residuals(start_nominal, outcome.nominal.full(), static_cast<int>(r), &before) &&
        calc_residuals(start_after, after.full(), static_cast<int>(r), &fitted)) {
      entry["map"] = make_map(problem, static_cast<int>(r), before, fitted);
      entry["traces"] = make_traces(problem, static_cast<int>(r), outcome, before, fitted);
    }
    recordings.push_back(entry);
  }
  series["signals"] = signals;
  series["recordings"] = recordings;
  series["rivals"] = make_rivals(problem, outcome);
  series["notes"] = e.warnings;
  return series;
}

}  // namespace hrp::diagnosis
