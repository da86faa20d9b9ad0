// SPDX-License-Identifier: BSD-3-Clause
// Motions are looked at before they are used.
#include <algorithm>

#include "diagnosis/identification/bush_angles.h"
#include "diagnosis/identification/motions.h"

namespace hrp::identification {

namespace {

constexpr double kLeastAir = 2.0;  // [s] on one foot, for the motion to be one of single support

Eigen::ArrayXd select(const Eigen::ArrayXd& values, const Mask& mask) {
  Eigen::ArrayXd chosen(mask.count());
  for (Eigen::Index k = 0, at = 0; k < mask.size(); ++k) {
    if (mask[k]) chosen[at++] = values[k];
  }
  return chosen;
}

void look_at_excitation(const MotionTrack& track, size_t f, MotionCheck* check) {
  const BushTrack& foot = track.feet[f];
  for (int a = 0; a < kAxes; ++a) {
    const Eigen::ArrayXd angle = select(foot.angle[a], track.stands[f]), rate = select(foot.rate[a], track.stands[f]);
    Eigen::MatrixXd X(angle.size(), 3);
    X << angle, rate, Eigen::VectorXd::Ones(angle.size());
    const Eigen::MatrixXd scaled = X * X.colwise().norm().cwiseInverse().asDiagonal();
    const Eigen::VectorXd values = Eigen::JacobiSVD<Eigen::MatrixXd>(scaled).singularValues();
    check->condition = std::max(check->condition, values[0] / std::max(values[2], 1e-12));
    check->fisher[f][a] = X.transpose() * X * track.period;
  }
}

}  // namespace

MotionCheck check_motion(const std::string& scenario_path, int lifted) {
  const Scenario scenario = without_sensor_errors(load_scenario(scenario_path));
  const BushObserver observer(scenario);
  const MotionTrack track = observer.observe(run_in_process(scenario), std::vector<SensorZero>(scenario.feet.size()));
  const std::vector<FootFrame>& feet = observer.feet();
  MotionCheck check;
  check.margin = check.smallest_load = 1e9;
  check.as_planned = true;
  for (size_t f = 0; f < track.feet.size(); ++f) {
    const BushTrack& foot = track.feet[f];
    const bool is_lifted = static_cast<int>(f) == lifted;
    const Mask all = Mask::Constant(track.time.size(), true), use = is_lifted ? track.stands[f] : all;
    if (is_lifted) {
      check.in_the_air = track.period * static_cast<double>((foot.load.array() < kAirborne).count());
      if (check.in_the_air < kLeastAir) check.as_planned = false;
    } else if (!track.stands[f].all()) {
      check.as_planned = false;
    }
    if (!use.any()) continue;
    check.smallest_load = std::min(check.smallest_load, select(foot.load, use).minCoeff());
    for (int i = 0; i < 2; ++i) {
      const Eigen::ArrayXd p = select(foot.zmp.row(i).transpose(), use);
      check.margin =
          std::min({check.margin, feet[f].sole.max()[i] - p.maxCoeff(), p.minCoeff() - feet[f].sole.min()[i]});
    }
    if (!is_lifted) look_at_excitation(track, f, &check);
  }
  return check;
}

}  // namespace hrp::identification
