// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/slip.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "diagnosis/estimate/at_rest.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/standing/channels.h"

namespace hrp::diagnosis::standing {
namespace {

// Distance [m] that the feet moved relative to each other since the previous sample; -1 unless both stand flat.
std::vector<double> find_slides(const StandProblem& p, const StandBase& base) {
  const std::vector<double>& residuals = base.residuals;
  const std::vector<char>& flat = base.flat;
  const size_t channels = residuals.size() / flat.size(), first = find_places(p) + (p.base_pose ? 3 : 0);
  std::vector<double> out(1, -1.0);
  for (size_t k = 1; k < flat.size(); ++k) {
    double moved = 0;
    for (size_t c = first; c < first + 3 * (p.feet.size() - 1); ++c) {
      if ((c - first) % 3 == 2) continue;  // vertical
      moved = std::max(moved, std::abs(residuals[k * channels + c] - residuals[(k - 1) * channels + c]));
    }
    out.push_back(flat[k] && flat[k - 1] ? moved : -1);
  }
  return out;
}

// Mean distance [m] of a rectangle's points from its centre; 0 for a ball or an unknown sole.
double find_lever(const StandFoot& foot) {
  const double a = foot.size.x() / 2, b = foot.size.y() / 2, d = std::hypot(a, b);
  if (foot.kind == SoleKind::kBall || d > 100) return 0;
  return d / 3 + a * a / (6 * b) * std::log((b + d) / a) + b * b / (6 * a) * std::log((a + d) / b);
}

}  // namespace

double find_asked_friction(const StandFoot& foot, const Vector3d& force, const Vector3d& torque, double vertical) {
  const double lever = find_lever(foot), push = force.head<2>().norm() / vertical;
  if (lever == 0) return push;
  // At the pressure point the moment is vertical. Its component along the force is the same at every point.
  const double turn = (torque - foot.sole.cross(force)).dot(force) / vertical;
  return std::hypot(push, turn / (vertical * lever));
}

double find_rest(const std::vector<std::vector<double>>& slides) {
  double rest = 1e300;
  for (const std::vector<double>& one : slides) {
    std::vector<double> sorted;
    std::copy_if(one.begin(), one.end(), std::back_inserter(sorted), [](double s) { return s >= 0; });
    if (sorted.size() < kFewestToTell) continue;
    std::sort(sorted.begin(), sorted.end());
    rest = std::min(rest, sorted[sorted.size() / 4]);
  }
  return rest;
}

bool find_slip_ratio(const StandProblem& problem, double* ratio, double* spread) {
  if (problem.feet.size() < 2) return false;
  std::vector<StandBase> bases(problem.recordings.size());
  std::vector<std::vector<double>> slides;
  StandProblem whole = problem;  // all samples: feet start and stop sliding with a jerk
  for (size_t r = 0; r < bases.size(); ++r) {
    whole.recordings[r].samples = whole.recordings[r].grid;
    calc_channels(whole, {}, r, &bases[r]);
    slides.push_back(find_slides(problem, bases[r]));
  }
  const double rest = find_rest(slides);
  std::vector<double> slipping;
  for (size_t r = 0; r < bases.size(); ++r) {
    const StandRecording& recording = whole.recordings[r];
    const double step = recording.time[static_cast<size_t>(recording.samples[1])] -
                        recording.time[static_cast<size_t>(recording.samples[0])];
    for (size_t k = 1; k < slides[r].size(); ++k) {
      // Encoder noise is what the quietest quarter moves by.
      if (slides[r][k] > std::max(kMoving * step, kTenTimes * rest)) slipping.push_back(bases[r].ratios[k]);
    }
  }
  // Uses the densest half. A foot that turns while it slides, or is about to stop, shows less than the full friction.
  const size_t n = slipping.size(), half = n / 2;
  if (n < kFewestToTell) return false;
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

}  // namespace hrp::diagnosis::standing
