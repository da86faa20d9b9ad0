// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/report/mismatches.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "diagnosis/estimate/at_rest.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/fit/remaining.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr size_t kMostMismatches = 24;

// Times of an equation's largest residuals, by recording, and how many of them are in each phase.
struct Departure {
  Mismatch mismatch;
  std::map<int, int> phases;  // rows by phase
};

std::map<int, Departure> find_departures(const ChannelRows& rows, double limit) {
  std::map<int, Departure> out;
  for (size_t i = 0; i < rows.rows(); ++i) {
    if (std::abs(rows.y[i]) < limit) continue;
    Departure& d = out[rows.recording[i]];
    std::vector<std::pair<double, double>>& intervals = d.mismatch.intervals;
    ++d.phases[rows.phase[i]];
    if (!intervals.empty() && rows.time[i] < intervals.back().second + kPause) {
      intervals.back().second = rows.time[i];
    } else if (intervals.size() < kShortList) {
      intervals.emplace_back(rows.time[i], rows.time[i]);
    }
  }
  return out;
}

int find_main_phase(const std::map<int, int>& phases) {
  int phase = 0, most = 0;
  for (const auto& [p, rows] : phases) {
    if (rows > most) {
      most = rows;
      phase = p;
    }
  }
  return phase;
}

void add_equation(size_t c, double score, ReportState* state) {
  const ChannelRows& rows = state->fitter.channels()[c];
  const double square = get_mean_square(state->fitter, state->outcome.nominal, c) + state->fitter.floor(c);
  for (auto& [r, d] : find_departures(rows, kAboveNoise * std::sqrt(square))) {
    Mismatch& m = d.mismatch;
    m.signal = rows.info.signal;
    m.score = score;
    m.regime = state->contacts.find_phase_name(find_main_phase(d.phases));
    m.recording = state->log.experiment->recordings[static_cast<size_t>(r)].spec.name;
    state->evidence.mismatch.push_back(m);
  }
}

}  // namespace

void add_mismatches(ReportState* state) {
  const LeggedFitter& fitter = state->fitter;
  const LeggedFit& nominal = state->outcome.nominal;
  for (size_t c = 0; c < fitter.channels().size(); ++c) {
    if (fitter.channels()[c].rows() == 0) continue;
    const double before = get_mean_square(fitter, nominal, c), score = std::sqrt(before / fitter.floor(c));
    const bool told = is_left(fitter, nominal, c) || get_mean_square(fitter, state->model, c) < kLargely * before;
    if (score >= 1 && told) add_equation(c, score, state);
  }
  std::vector<Mismatch>& all = state->evidence.mismatch;
  std::stable_sort(all.begin(), all.end(), [](const Mismatch& a, const Mismatch& b) { return a.score > b.score; });
  if (all.size() > kMostMismatches) all.resize(kMostMismatches);
}

}  // namespace hrp::diagnosis::floating
