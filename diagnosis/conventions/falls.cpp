// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/falls.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "common/base/format.h"
#include "diagnosis/data/gaps.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/data/range.h"
#include "diagnosis/data/stretches.h"
#include "diagnosis/estimate/at_rest.h"

namespace hrp::diagnosis {
namespace {

constexpr double kCrash = 20.0;  // a stiff robot that stamps lands with ten times its weight in single samples

// Length of each reading of a sensor of three axes, or of those that were recorded; by sensor.
std::map<std::string, std::vector<double>> list_lengths(const Recording& r, const std::string& kind) {
  std::map<std::string, std::vector<double>> lengths;
  for (const auto& [name, column] : r.other) {
    const size_t at = name.rfind(kind);
    if (at == std::string::npos || at + kind.size() + 1 != name.size()) continue;
    std::vector<double>& sum = lengths[name.substr(0, at)];
    sum.resize(column.size(), 0.0);
    for (size_t k = 0; k < column.size(); ++k) sum[k] = std::hypot(sum[k], column[k]);
  }
  return lengths;
}

// What a sensor reads more of than kCrash times what it reads most of the time.
struct Peak {
  double time = 0.0;   // [s]
  double times = 0.0;  // what it reads most of the time
};

// Of any of the sensors, in the order of time. A foot in the air reads little: forces are compared with the foot that
// bears most.
std::vector<Peak> list_peaks(const Recording& r, const std::string& kind) {
  const std::map<std::string, std::vector<double>> sensors = list_lengths(r, kind);
  double usual = 0.0;
  for (const auto& [name, lengths] : sensors) usual = std::max(usual, find_median(keep_finite(lengths)));
  std::vector<Peak> peaks;
  for (size_t k = 0; k < r.size() && usual > 0.0; ++k) {
    for (const auto& [name, lengths] : sensors) {
      if (lengths[k] > kCrash * usual) peaks.push_back({r.time[k], lengths[k] / usual});
    }
  }
  return peaks;
}

}  // namespace

std::vector<Crash> find_crashes(const Experiment& e) {
  std::vector<Crash> crashes;
  for (size_t i = 0; i < e.recordings.size(); ++i) {
    const std::vector<Peak> felt = list_peaks(e.recordings[i], "/linear_acceleration/"),
                            pressed = list_peaks(e.recordings[i], "/force/");
    auto force = pressed.begin();
    for (const Peak& a : felt) {
      while (force != pressed.end() && force->time < a.time - kMoment) ++force;
      if (force == pressed.end()) break;
      if (force->time > a.time + kMoment) continue;
      crashes.push_back({i, std::min(a.time, force->time), a.times});
      break;
    }
  }
  return crashes;
}

Experiment cut_at_crashes(Experiment e) {
  const std::vector<Crash> crashes = find_crashes(e);
  if (crashes.empty()) return e;
  std::vector<Recording> kept = e.recordings;
  std::vector<std::string> warnings;
  for (const Crash& crash : crashes) {
    const Recording& r = e.recordings[crash.recording];
    const auto end = std::lower_bound(r.time.begin(), r.time.end(), crash.time - kScrape) - r.time.begin();
    const bool enough = end > 0 && r.time[static_cast<size_t>(end) - 1] - r.time.front() >= kShortestPart;
    Recording& left = kept[crash.recording];
    left = enough ? cut_recording(r, 0, static_cast<size_t>(end)) : Recording{};
    left.spec.name = r.spec.name;
    warnings.push_back(format("%s: at %.2f s an accelerometer reads %.0f times what it reads most of the time, and so "
                              "does a foot's force: the robot falls, or is hit; ",
                              r.spec.name.c_str(), crash.time, crash.times) +
                       (enough ? "what follows is left out" : "the recording is left out"));
  }
  kept.erase(std::remove_if(kept.begin(), kept.end(), [](const Recording& r) { return r.time.empty(); }), kept.end());
  if (kept.empty()) return e;
  e.recordings = std::move(kept);
  e.warnings.insert(e.warnings.end(), warnings.begin(), warnings.end());
  return e;
}

}  // namespace hrp::diagnosis
