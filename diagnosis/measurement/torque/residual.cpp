// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/torque/residual.h"

#include <cmath>

#include "diagnosis/measurement/torque/terms.h"
#include "diagnosis/model/memory.h"
#include "diagnosis/simulation/bodies.h"

namespace hrp::diagnosis {
namespace {

// Torque [N m] of friction with memory along the recorded motion; it starts unbent.
Eigen::VectorXd calc_memory(const JointLaws& laws, const Eigen::VectorXd& q) {
  if (!(laws.hysteresis_stiffness > 0.0)) return Eigen::VectorXd::Zero(q.size());
  return laws.hysteresis_stiffness * laws.hysteresis_yield *
         calc_memory_state(get_effect(EffectId::kHysteresis), q, laws.hysteresis_yield);
}

// Torque [N m] of a joint's laws in addition to the bodies, on the full grid.
Eigen::VectorXd calc_taken(const TorqueData& data, const JointLaws& laws, const TorqueRecording& r,
                           const Eigen::VectorXd& tau, int j) {
  const Eigen::VectorXd direction = data.calc_sign(r, j);
  Eigen::VectorXd taken = calc_memory(laws, r.q.col(j));
  for (long k = 0; k < tau.size(); ++k) {
    const double v = r.v(k, j), s = direction[k];
    taken[k] += calc_taken_torque(laws, r.q(k, j) - laws.joint_offset, v, r.a(k, j));
    if (!laws.has_friction()) continue;
    taken[k] += s * (calc_friction_level(laws, std::abs(r.speed(k, j)), calc_given_torque(laws, r.load(k, j), v),
                                         s > 0.0 ? 1.0 : -1.0) +
                     calc_backdriven_level(laws, tau[k], s));
  }
  return taken;
}

Eigen::MatrixXd take_offsets(const Plant& plant, Eigen::MatrixXd q) {
  for (long j = 0; j < q.cols(); ++j) q.col(j).array() -= plant.laws[static_cast<size_t>(j)].joint_offset;
  return q;
}

}  // namespace

Eigen::MatrixXd calc_bodies(const TorqueData& data, const Plant& plant, const TorqueRecording& r) {
  const Plant here = add_by_hand(plant, data.experiment->recordings[r.index].spec);
  const JointsMotion links = follow_drives(here, {take_offsets(plant, r.q), r.v, r.a}, r.step);
  return r.smooth_torque(calc_efforts(here, links.q, links.v, links.a));
}

std::vector<double> calc_torque_left(const TorqueData& data, const TorqueRecording& r, const Plant& plant,
                                     const Eigen::VectorXd& tau, int j) {
  const JointLaws& laws = plant.laws[static_cast<size_t>(j)];
  const double log_delay = get_effort_delay(plant, j);
  const CalcLate late = find_late(data, j);
  const Eigen::VectorXd taken = data.condition(r, calc_taken(data, laws, r, tau, j));
  std::vector<double> left;
  for (long k = 0; k < r.kept(); ++k) {
    if (!r.use(k, j)) continue;
    const long row = r.full_row(k);
    const double effort = r.effort(row, j) - laws.command_delay * late(r, j, row, laws.command_delay) -
                          laws.lag * r.effort_rate(row, j) + log_delay * calc_coming(r, j, row, log_delay);
    left.push_back((calc_given_torque(laws, effort, r.v(row, j)) - tau[row] - taken[k]) / laws.torque_scale);
  }
  return left;
}

std::vector<double> calc_torque_residuals(const TorqueData& data, const Plant& plant, bool held) {
  const size_t n = plant.laws.size();
  std::vector<double> square(n, 0.0), count(n, 0.0);
  for (const TorqueRecording& r : data.recordings) {
    if (r.train == held) continue;
    const Eigen::MatrixXd tau = calc_bodies(data, plant, r);
    for (size_t i = 0; i < n; ++i) {
      const int j = static_cast<int>(i);
      if (!data.is_judged(j)) continue;
      for (double left : calc_torque_left(data, r, plant, tau.col(j), j)) {
        square[i] += left * left;
        count[i] += 1.0;
      }
    }
  }
  std::vector<double> rms;
  for (size_t i = 0; i < n; ++i) rms.push_back(count[i] > 0.0 ? std::sqrt(square[i] / count[i]) : std::nan(""));
  return rms;
}

}  // namespace hrp::diagnosis
