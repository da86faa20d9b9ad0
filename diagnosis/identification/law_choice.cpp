// SPDX-License-Identifier: BSD-3-Clause
// Validation, and the law that predicts best what it has not seen.
#include <algorithm>
#include <cmath>

#include "diagnosis/identification/bush_rows.h"

namespace hrp::identification {
namespace {

constexpr double kEnough = 1.0;        // [s] of standing, to say anything of a foot in a motion
constexpr double kGain = 0.9;          // errors must fall at least to this
constexpr double kSignificance = 4.0;  // standard deviations

double calc_error_left_out(const std::vector<MotionTrack>& tracks, const std::vector<SensorZero>& zeros,
                           const std::vector<Vector3d>& arms, const FitOptions& options) {
  double sum = 0.0, count = 0.0;
  for (size_t out = 0; out < tracks.size(); ++out) {
    std::vector<MotionTrack> others = tracks;
    others.erase(others.begin() + static_cast<long>(out));
    if (others.empty()) continue;
    const BushFit fit = fit_bush(others, zeros, arms, options);
    const MotionTrack& track = tracks[out];
    for (size_t f = 0; f < track.feet.size(); ++f) {
      const Eigen::ArrayXd usable = track.find_usable(f, options.skip).cast<double>();
      for (int a = 0; a < kAxes; ++a) {
        sum += ((track.feet[f].torque[a] - predict_torque(fit, track, f, a)).array() * usable).square().sum();
        count += usable.sum();
      }
    }
  }
  return std::sqrt(sum / std::max(1.0, count));
}

double calc_significance(const BushFit& fit) {
  double most = 0.0;
  for (const auto& foot : fit.feet) {
    for (const BushParameters& p : foot) {
      const Estimate& more = fit.law == BushLaw::kHardening ? p.cubic : p.hysteresis;
      if (more.std > 0.0) most = std::max(most, more.value / more.std);
    }
  }
  return most;
}

}  // namespace

std::vector<ValidationError> validate(const BushFit& fit, const std::vector<MotionTrack>& tracks) {
  std::vector<ValidationError> errors;
  for (const MotionTrack& track : tracks) {
    for (size_t f = 0; f < track.feet.size(); ++f) {
      const Eigen::ArrayXd usable = track.find_usable(f, fit.skip).cast<double>();
      if (usable.sum() * track.period < kEnough) continue;
      for (int a = 0; a < kAxes; ++a) {
        const Eigen::ArrayXd torque = track.feet[f].torque[a].array() * usable;
        const Eigen::ArrayXd error = torque - predict_torque(fit, track, f, a).array() * usable;
        errors.push_back(
            {track.name, f, a, usable.sum() * track.period, error.abs().sum() / usable.sum(), torque.abs().maxCoeff()});
      }
    }
  }
  return errors;
}

LawChoice choose_law(const std::vector<MotionTrack>& tracks, const std::vector<SensorZero>& zeros,
                     const std::vector<Vector3d>& arms, const FitOptions& given) {
  LawChoice choice;
  FitOptions options = given;
  options.skip = kForget;
  for (int i = 0; i < kLaws; ++i) {
    options.law = static_cast<BushLaw>(i);
    if (i > 0) {
      const BushFit fit = fit_bush(tracks, zeros, arms, options);
      choice.significance[i] = calc_significance(fit);
      options.yield = fit.yield.value;
    }
    choice.error[i] = calc_error_left_out(tracks, zeros, arms, options);
    const double best = choice.error[static_cast<int>(choice.law)];
    if (i > 0 && choice.significance[i] > kSignificance && choice.error[i] < kGain * choice.error[0] &&
        choice.error[i] < best) {
      choice.law = options.law;
    }
  }
  return choice;
}

}  // namespace hrp::identification
