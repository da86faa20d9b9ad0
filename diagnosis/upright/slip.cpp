// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/upright/slip.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/upright/channels.h"

namespace hrp::diagnosis::upright {
namespace {

constexpr double kSlide = 0.01;  // [m/s] a foot that is faster slides

// Distance that the feet moved against each other from each sample to the next [m], where both stand flat; else -1.
std::vector<double> find_slides(const StandProblem& p, const StandBase& base) {
  const std::vector<double>& residuals = base.residuals;
  const std::vector<char>& flat = base.flat;
  const size_t channels = residuals.size() / flat.size(), first = find_places(p) + (p.base_pose ? 3 : 0);
  std::vector<double> out(1, -1.0);
  for (size_t k = 1; k < flat.size(); ++k) {
    double moved = 0;
    for (size_t c = first; c < first + 3 * (p.feet.size() - 1); ++c) {
      if ((c - first) % 3 == 2) continue;  // across the ground
      moved = std::max(moved, std::abs(residuals[k * channels + c] - residuals[(k - 1) * channels + c]));
    }
    out.push_back(flat[k] && flat[k - 1] ? moved : -1);
  }
  return out;
}

}  // namespace

bool find_slip_ratio(const StandProblem& problem, double* ratio, double* spread) {
  if (problem.feet.size() < 2) return false;
  std::vector<double> slipping;
  StandProblem whole = problem;  // feet begin and cease to slide with a jerk: those samples are not kept
  for (size_t r = 0; r < problem.recordings.size(); ++r) {
    StandRecording& recording = whole.recordings[r];
    recording.samples = recording.grid;
    StandBase base;
    calc_channels(whole, {}, r, &base);
    const std::vector<double> slides = find_slides(problem, base);
    std::vector<double> sorted;
    for (double s : slides) {
      if (s >= 0) sorted.push_back(s);
    }
    if (sorted.size() < 20) continue;
    std::sort(sorted.begin(), sorted.end());
    const double least = std::max(kSlide * (recording.time[static_cast<size_t>(recording.samples[1])] -
                                            recording.time[static_cast<size_t>(recording.samples[0])]),
                                  8 * sorted[sorted.size() / 4]);  // a quarter of the samples rest: noise
    for (size_t k = 1; k < slides.size(); ++k) {
      if (slides[k] > least) slipping.push_back(base.ratios[k]);
    }
  }
  // The densest half: a foot that turns as it slides feels less than the whole friction, one that is about to stop too.
  const size_t n = slipping.size(), half = n / 2;
  if (n < 20) return false;
  std::sort(slipping.begin(), slipping.end());
  size_t best = 0;
  for (size_t i = 0; i + half < n; ++i) {
    if (slipping[i + half] - slipping[i] < slipping[best + half] - slipping[best]) best = i;
  }
  *ratio = 0;
  for (size_t i = best; i <= best + half; ++i) *ratio += slipping[i] / static_cast<double>(half + 1);
  *spread = (slipping[best + half] - slipping[best]) / 2;
  return *spread < 0.2 * *ratio && *ratio < problem.experiment->scenario.ground.friction;
}

}  // namespace hrp::diagnosis::upright
