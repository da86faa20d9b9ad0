// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/report/series.h"
#include "diagnosis/estimate/enough.h"

#include <algorithm>
#include <cmath>

namespace hrp::diagnosis::floating {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kMostPoints = 500;  // of a curve, about

// Equations by their mismatch over noise, the largest first.
std::vector<size_t> list_main_equations(const LeggedFitter& fitter, const LeggedFit& nominal) {
  std::vector<size_t> out;
  for (size_t c = 0; c < fitter.channels().size(); ++c) {
    if (fitter.channels()[c].rows() > 0) out.push_back(c);
  }
  const auto score = [&](size_t c) { return nominal.mean_square[1][c] / fitter.floor(c); };
  std::stable_sort(out.begin(), out.end(), [&](size_t a, size_t b) { return score(a) > score(b); });
  if (out.size() > kMostInList) out.resize(kMostInList);
  return out;
}

Json make_signal(const LeggedFitter& fitter, size_t c) {
  const ChannelInfo& info = fitter.channels()[c].info;
  return {{"name", info.signal + ": " + info.name + ", " + get_text(info.equation)},
          {"unit", info.unit},
          {"noise", std::sqrt(fitter.floor(c))},
          {"noise_source", "estimated"}};
}

Json make_trace(const ChannelRows& rows, const std::vector<double>& left, size_t signal, size_t recording) {
  Json time = Json::array(), recorded = Json::array(), before = Json::array(), after = Json::array();
  const size_t skip = rows.rows() / kMostPoints + 1;
  for (size_t i = 0; i < rows.rows(); i += skip) {
    if (rows.recording[i] != static_cast<int>(recording)) continue;
    time.push_back(rows.time[i]);
    recorded.push_back(rows.y[i]);
    before.push_back(0.0);
    after.push_back(rows.y[i] - left[i]);
  }
  return {{"signal", signal}, {"time", time}, {"recorded", recorded}, {"before", before}, {"after", after}};
}

}  // namespace

Json make_series(const Experiment& e, const LeggedFitter& fitter, const LeggedOutcome& outcome,
                 const Evidence& evidence) {
  Json series{{"schema", 1}, {"experiment", e.path}, {"robot", e.robot.tree.name}};
  Json signals = Json::array(), recordings = Json::array();
  const std::vector<size_t> equations = list_main_equations(fitter, outcome.nominal);
  std::vector<std::vector<double>> left;
  for (size_t c : equations) {
    signals.push_back(make_signal(fitter, c));
    left.push_back(fitter.calc_residuals(outcome.chosen, c));
  }
  for (size_t r = 0; r < e.recordings.size(); ++r) {
    const Recording& recording = e.recordings[r];
    Json traces = Json::array();
    for (size_t s = 0; s < equations.size(); ++s)
      traces.push_back(make_trace(fitter.channels()[equations[s]], left[s], s, r));
    recordings.push_back({{"file", recording.spec.name},
                          {"role", recording.spec.train ? "train" : "validate"},
                          {"start", recording.time.front()},
                          {"end", recording.time.back()},
                          {"traces", traces}});
  }
  series["signals"] = signals;
  series["recordings"] = recordings;
  series["notes"] = e.warnings;
  for (const std::string& text : evidence.warnings) series["notes"].push_back(text);
  for (const std::string& text : evidence.missing) series["notes"].push_back("missing: " + text);
  return series;
}

}  // namespace hrp::diagnosis::floating
