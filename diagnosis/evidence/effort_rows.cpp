// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/effort_rows.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/measurement/torque/residual.h"

namespace hrp::diagnosis {
namespace {

double sum_squares(const std::vector<double>& x) {
  double sum = 0.0;
  for (double value : x) sum += value * value;
  return sum;
}

bool moves_bodies(const Effect& effect) {
  const PlaceKind kind = effect.place.kind;
  return effect.id == EffectId::kJointOffset || get_effect(effect.id).flexible ||
         (kind != PlaceKind::kJoint && kind != PlaceKind::kSensor);
}

}  // namespace

EffortRows::EffortRows(const Experiment& e, const TorqueData& data, const Hypothesis& links) {
  Bodies bodies{&e, &data, links, {}};
  const Plant plant = make_plant(e, links);
  for (const TorqueRecording& r : data.recordings) bodies.tau.push_back(calc_bodies(data, plant, r));
  bodies_ = std::make_shared<const Bodies>(std::move(bodies));
}

CalcResiduals EffortRows::add_to(const CalcResiduals& simulated, const std::vector<int>& train, const Hypothesis& at,
                                 int joint) const {
  std::vector<int> joints;
  for (int j = 0; j < bodies_->experiment->num_joints(); ++j) {
    if (bodies_->data->is_judged(j) && (joint < 0 || joint == j)) joints.push_back(j);
  }
  const auto make_beside = [bodies = bodies_](Hypothesis h) {
    h.insert(h.end(), bodies->links.begin(), bodies->links.end());
    return make_plant(*bodies->experiment, h);
  };
  // Residual torque [N m] in one recording, by joint.
  const auto calc_left = [joints, bodies = bodies_](const Plant& plant, const Hypothesis& h, size_t recording) {
    const TorqueRecording& r = bodies->data->recordings[recording];
    const bool moved = std::any_of(h.begin(), h.end(), moves_bodies);
    const Eigen::MatrixXd tau = moved ? calc_bodies(*bodies->data, plant, r) : bodies->tau[recording];
    std::vector<std::vector<double>> left;
    for (int j : joints) left.push_back(calc_torque_left(*bodies->data, r, plant, tau.col(j), j));
    return left;
  };
  // Each joint's efforts are weighted by the inverse of their residual at `at`. All efforts together weigh as much as
  // the simulation's chi-square.
  const Score score = calc_score(simulated, 1, at, train);
  if (!score.ok || joints.empty()) return simulated;
  const Plant plant = make_beside(at);
  std::vector<double> weights(joints.size(), 0.0);
  for (size_t r = 0; r < bodies_->tau.size(); ++r) {
    if (!bodies_->data->recordings[r].train) continue;
    const std::vector<std::vector<double>> left = calc_left(plant, at, r);
    for (size_t i = 0; i < joints.size(); ++i) weights[i] += sum_squares(left[i]);
  }
  for (double& w : weights) w = w > 0.0 ? std::sqrt(score.chi2 / static_cast<double>(joints.size()) / w) : 0.0;
  return [=, bodies = bodies_](const Hypothesis& hypothesis, int recording, std::vector<double>* residuals) {
    if (!simulated(hypothesis, recording, residuals)) return false;
    const Plant own = make_beside(hypothesis);
    for (size_t r = 0; r < bodies->tau.size(); ++r) {
      if (bodies->data->recordings[r].index != static_cast<size_t>(recording)) continue;
      const std::vector<std::vector<double>> of_joints = calc_left(own, hypothesis, r);
      for (size_t i = 0; i < joints.size(); ++i) {
        for (double left : of_joints[i]) residuals->push_back(weights[i] * left);
      }
    }
    return true;
  };
}

}  // namespace hrp::diagnosis
