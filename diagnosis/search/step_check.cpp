// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/step_check.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/search/step_error.h"

namespace hrp::diagnosis {
namespace {

// Share of the samples in which the nominal servo of a joint is at its limit.
double find_limited(const Problem& problem, const Plant& plant, int joint) {
  const JointLaws& laws = plant.laws[static_cast<size_t>(joint)];
  if (!std::isfinite(laws.effort_limit)) return 0.0;
  const size_t width = plant.laws.size() * kQuantities,
               at = static_cast<size_t>(joint) * kQuantities + static_cast<size_t>(Quantity::kEffort);
  double limited = 0.0, all = 0.0;
  for (int r : problem.train) {
    const auto i = static_cast<size_t>(r);
    std::vector<double> readings;
    const Recording& recording = problem.experiment->recordings[i];
    if (!simulate_recording(add_by_hand(plant, recording.spec), recording, problem.smooth[i], problem.options,
                            &readings))
      continue;
    for (size_t k = problem.smooth[i].judged; k < recording.size(); ++k) {
      limited += std::abs(readings[k * width + at]) > 0.999 * laws.effort_limit ? 1.0 : 0.0;
      all += 1.0;
    }
  }
  return limited / std::max(1.0, all);
}

}  // namespace

std::vector<SuspectJoint> find_suspect_joints(const Problem& problem) {
  const Plant plant = make_plant(*problem.experiment, {});
  const StepErrors errors = estimate_step_errors(problem, {}, problem.train, 2);
  const Score score = calc_score(problem, {}, problem.train);
  std::vector<SuspectJoint> found;
  if (!score.ok) return found;
  const size_t width = problem.weights.size();
  for (size_t c = 0; c < width; ++c) {
    double sum = 0.0, count = 0.0;
    for (int r : problem.train) {
      const std::vector<double>& error = errors[static_cast<size_t>(r)];
      for (size_t k = problem.smooth[static_cast<size_t>(r)].judged; (k + 1) * width <= error.size(); ++k) {
        sum += std::pow(error[k * width + c] * problem.weights[c], 2);
        count += 1.0;
      }
    }
    const double change = std::sqrt(sum / std::max(1.0, count)), left = score.rms(c);
    if (left <= 0.0 || change < kUnlikely || change < kMuch * left) continue;
    const int joint = static_cast<int>(c) / kQuantities;
    if (!found.empty() && found.back().joint == joint) {
      if (change > found.back().change) {
        found.back().change = change;
        found.back().left = left;
      }
    } else {
      found.push_back({joint, change, left, find_limited(problem, plant, joint) > kDetail});
    }
  }
  return found;
}

}  // namespace hrp::diagnosis
