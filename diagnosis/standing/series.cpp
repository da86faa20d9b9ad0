// SPDX-License-Identifier: BSD-3-Clause
// Data for the plots of a standing robot's diagnosis on the page.
#include <algorithm>
#include <cmath>

#include "diagnosis/standing/findings.h"

namespace hrp::diagnosis::standing {
namespace {

constexpr int kMapBins = 120;  // of time: as many as a map on a page shows

// Rms in units of noise, by bin of time.
Json make_map_row(const StandRecording& rec, const std::vector<double>& residuals, size_t channels, size_t c,
                  double sigma) {
  const double start = rec.time[static_cast<size_t>(rec.samples.front())];
  const double end = rec.time[static_cast<size_t>(rec.samples.back())];
  std::vector<double> sum(kMapBins), n(kMapBins);
  for (size_t s = 0; s < rec.samples.size(); ++s) {
    const double t = rec.time[static_cast<size_t>(rec.samples[s])], z = residuals[s * channels + c] / sigma;
    const auto bin = static_cast<size_t>(std::min(kMapBins - 1.0, (t - start) / (end - start) * kMapBins));
    sum[bin] += z * z;
    ++n[bin];
  }
  Json out = Json::array();
  for (size_t i = 0; i < sum.size(); ++i) out.push_back(n[i] > 0 ? Json(std::sqrt(sum[i] / n[i])) : Json());
  return out;
}

Json make_trace(const StandRecording& rec, const std::vector<double>& before, const std::vector<double>& after,
                size_t channels, size_t c) {
  Json time = Json::array(), zero = Json::array(), b = Json::array(), a = Json::array();
  for (size_t s = 0; s < rec.samples.size(); ++s) {
    time.push_back(rec.time[static_cast<size_t>(rec.samples[s])]);
    zero.push_back(0.0);
    b.push_back(before[s * channels + c]);
    a.push_back(after[s * channels + c]);
  }
  return {{"signal", c}, {"time", time}, {"recorded", zero}, {"before", b}, {"after", a}};
}

Json make_recording(const StandProblem& p, const StandOutcome& o, size_t r, const std::vector<double>& before,
                    const std::vector<double>& after) {
  const StandRecording& rec = p.recordings[r];
  const size_t channels = o.channels.size();
  const double start = rec.time[static_cast<size_t>(rec.samples.front())];
  const double end = rec.time[static_cast<size_t>(rec.samples.back())];
  Json rows = Json::array(), traces = Json::array();
  std::vector<std::pair<double, size_t>> worst;
  for (size_t c = 0; c < channels; ++c) {
    rows.push_back({{"signal", c},
                    {"before", make_map_row(rec, before, channels, c, o.sigma[c])},
                    {"after", make_map_row(rec, after, channels, c, o.sigma[c])}});
    double total = 0;
    for (size_t k = c; k < before.size(); k += channels) total += std::pow(before[k] / o.sigma[c], 2);
    worst.emplace_back(-total, c);
  }
  std::sort(worst.begin(), worst.end());
  for (size_t i = 0; i < std::min<size_t>(4, worst.size()); ++i) {
    traces.push_back(make_trace(rec, before, after, channels, worst[i].second));
  }
  return {{"file", rec.file},
          {"role", rec.train ? "train" : "validate"},
          {"start", start},
          {"end", end},
          {"map", {{"start", start}, {"step", (end - start) / kMapBins}, {"rows", rows}}},
          {"traces", traces}};
}

Json make_rival(const StandProblem& p, const StandOutcome& o, size_t round, const StandTrial& t) {
  const Effect& e = t.fit.hypothesis[round];
  const auto [kind, name] = find_place(p, e);
  const bool chosen = round < o.chosen.hypothesis.size() && e.id == o.chosen.hypothesis[round].id &&
                      e.place == o.chosen.hypothesis[round].place;
  const std::vector<double>& rms = t.fit.channel_rms;
  const auto w = static_cast<size_t>(std::max_element(rms.begin(), rms.end()) - rms.begin());
  double sum = 0;
  for (double v : rms) sum += v * v;
  const std::string lost = "leaves " + number(rms[w], 2) + " times the noise in " + get_text(o.channels[w].kind) + " " +
                           o.channels[w].signal;
  return {{"effect", get_effect(e.id).name},
          {"where", {{kind, name}}},
          {"probability", t.probability},
          {"validate_score", std::sqrt(sum / static_cast<double>(rms.size()))},
          {"complexity", e.p.size()},
          {"chosen", chosen},
          {"why", chosen ? "agrees best with the recordings it was not fitted to" : lost}};
}

// Rms residual with the first n findings, for n = 0, 1, ...: shows what each one adds.
Json make_steps(const StandProblem& p, const StandOutcome& o) {
  const bool none_held = std::all_of(p.recordings.begin(), p.recordings.end(), [](const auto& r) { return r.train; });
  Json out = Json::array();
  Hypothesis h;
  for (size_t i = 0; i <= o.chosen.hypothesis.size(); ++i) {
    Json where;
    if (i > 0) {
      h.push_back(o.chosen.hypothesis[i - 1]);
      const auto [kind, name] = find_place(p, h.back());
      where = {{kind, name}};
    }
    out.push_back({{"effect", i > 0 ? get_effect(h.back().id).name : std::string()},
                   {"where", where},
                   {"held_out", calc_fit(p, o, evaluate(p, h), none_held)}});
  }
  return out;
}

}  // namespace

Json make_stand_series(const StandProblem& p, const StandOutcome& o) {
  Json out{{"schema", 1},
           {"robot", p.tree.name},
           {"signals", Json::array()},
           {"recordings", Json::array()},
           {"rivals", Json::array()}};
  for (size_t c = 0; c < o.channels.size(); ++c) {
    const Channel& channel = o.channels[c];
    const std::string name = get_text(channel.kind) + " " + (channel.foot.empty() ? channel.signal : channel.foot);
    out["signals"].push_back({{"name", name}, {"unit", ""}, {"noise", o.sigma[c]}, {"noise_source", "estimated"}});
  }
  const Evaluation before = evaluate(p, {}), after = evaluate(p, o.chosen.hypothesis);
  for (size_t r = 0; r < p.recordings.size(); ++r) {
    out["recordings"].push_back(make_recording(p, o, r, before[r].residuals, after[r].residuals));
  }
  for (size_t i = 0; i < o.rounds.size(); ++i) {
    for (const StandTrial& t : o.rounds[i]) {
      if (t.fit.score < 1e299) out["rivals"].push_back(make_rival(p, o, i, t));
    }
  }
  out["steps"] = make_steps(p, o);
  out["notes"] = {"Traces show what is left of each equation; recorded would be zero."};
  return out;
}

}  // namespace hrp::diagnosis::standing
