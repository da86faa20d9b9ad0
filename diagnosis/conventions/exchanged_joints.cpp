// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/exchanged_joints.h"

#include <utility>

#include "common/base/diagnostics.h"
#include "diagnosis/conventions/list_fit.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/measurement/motion_rows.h"
#include "diagnosis/simulation/bodies.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {
namespace {

using Pair = std::pair<int, int>;

// What friction and rotors leave if the columns of two joints are exchanged. Nothing changes with twice the same joint.
double calc_left(const Plant& plant, const SampledMotion& rows, const Pair& p) {
  Eigen::MatrixXd q = rows.q, v = rows.v, a = rows.a;
  for (Eigen::MatrixXd* m : {&q, &v, &a}) m->col(p.first).swap(m->col(p.second));
  Eigen::MatrixXd tau = calc_efforts(plant, q, v, a);
  tau.col(p.first).swap(tau.col(p.second));  // in the log's order
  return rows.calc_left(rows.effort - tau);
}

// The pair that leaves a detail of the mismatch; twice the same joint if there is none.
Pair find_pair(const TorqueData& data) {
  Pair best{0, 0};
  const SampledMotion rows = take_rows(data, list_unloaded_training(data));
  if (rows.tell_nothing()) return best;
  const Plant plant = make_plant(*data.experiment, {});
  const double nominal = calc_left(plant, rows, best);
  const double samples = (rows.weight.array() > 0.0).select(rows.use.colwise().sum().transpose().array(), 0.0).sum();
  if (nominal < kMuch * kMuch * samples)
    return best;  // friction and rotors explain nearly all: the joints are in place
  double least = kDetail * nominal;
  for (int i = 0; i < rows.q.cols(); ++i) {
    for (int j = i + 1; j < rows.q.cols(); ++j) {
      const double left = calc_left(plant, rows, {i, j});
      if (left < least) least = left, best = {i, j};
    }
  }
  return best;
}

Experiment exchange(Experiment e, const Pair& p) {
  for (Recording& r : e.recordings)
    std::swap(r.joints[static_cast<size_t>(p.first)], r.joints[static_cast<size_t>(p.second)]);
  std::swap(e.joint_noise[static_cast<size_t>(p.first)], e.joint_noise[static_cast<size_t>(p.second)]);
  return e;
}

}  // namespace

void check_exchanged_joints(const TorqueData& data, int jobs) {
  const Experiment& e = *data.experiment;
  if (data.recordings.empty() || data.behind_gears) return;
  const Pair pair = find_pair(data);
  if (pair.first == pair.second) return;
  if (compare(fit_list(exchange(e, pair), jobs), fit_list(make_torque_design(TorqueData(data)), jobs)) <
      kOfOneJoint + kConventionNats)
    return;
  const std::string first = e.robot.tree.joint(pair.first).name, second = e.robot.tree.joint(pair.second).name;
  refuse_input(e.recordings.front().find_place(e.signal_name(pair.first, Quantity::kPosition)),
               "with its effort fits the model in the place of " + second + " only: are the columns of " + first +
                   " and " + second + " exchanged?");
}

}  // namespace hrp::diagnosis
