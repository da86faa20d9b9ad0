// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/falls.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "common/base/format.h"
#include "diagnosis/data/quantile.h"
#include "diagnosis/data/stretches.h"

namespace hrp::diagnosis {
namespace {

constexpr double kCrash = 20.0;    // a stiff robot that stamps lands with ten times its weight in single samples
constexpr double kAtOnce = 0.05;   // [s]
constexpr double kBefore = 0.1;    // [s] that is left out before a crash: filters reach so far
constexpr double kShortest = 1.0;  // [s] of a recording that is used, as between gaps

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

double find_usual(const std::vector<double>& lengths) {
  std::vector<double> finite;
  for (double x : lengths) {
    if (std::isfinite(x)) finite.push_back(x);
  }
  return finite.empty() ? 0.0 : find_median(std::move(finite));
}

// Rows at which any of the sensors reads so much more than most of the time. A foot in the air reads little: forces are
// compared with the foot that bears most.
std::vector<size_t> list_peaks(const std::map<std::string, std::vector<double>>& sensors, double* largest) {
  double usual = 0.0;
  for (const auto& [name, lengths] : sensors) usual = std::max(usual, find_usual(lengths));
  std::vector<size_t> rows;
  for (const auto& [name, lengths] : sensors) {
    for (size_t k = 0; k < lengths.size() && usual > 0.0; ++k) {
      if (!(lengths[k] > kCrash * usual)) continue;
      rows.push_back(k), *largest = std::max(*largest, lengths[k] / usual);
    }
  }
  std::sort(rows.begin(), rows.end());
  return rows;
}

}  // namespace

std::vector<Crash> find_crashes(const Experiment& e) {
  std::vector<Crash> crashes;
  for (size_t i = 0; i < e.recordings.size(); ++i) {
    const Recording& r = e.recordings[i];
    double of_force = 0.0;
    Crash crash{i, HUGE_VAL, 0.0};
    const std::vector<size_t> felt = list_peaks(list_lengths(r, "/linear_acceleration/"), &crash.times),
                              pressed = list_peaks(list_lengths(r, "/force/"), &of_force);
    for (size_t a : felt) {
      for (size_t f : pressed) {
        if (std::abs(r.time[a] - r.time[f]) <= kAtOnce) crash.time = std::min({crash.time, r.time[a], r.time[f]});
      }
    }
    if (std::isfinite(crash.time)) crashes.push_back(crash);
  }
  return crashes;
}

Experiment cut_at_crashes(Experiment e) {
  std::vector<Recording> kept = e.recordings;
  std::vector<std::string> warnings;
  for (const Crash& crash : find_crashes(e)) {
    const Recording& r = e.recordings[crash.recording];
    const auto end = std::lower_bound(r.time.begin(), r.time.end(), crash.time - kBefore) - r.time.begin();
    const bool enough = end > 0 && r.time[static_cast<size_t>(end) - 1] - r.time.front() >= kShortest;
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
