// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/exchanged_joints.h"

#include <utility>

#include "common/base/diagnostics.h"
#include "diagnosis/conventions/list_fit.h"
#include "diagnosis/estimate/odds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/simulation/bodies.h"

namespace hrp::diagnosis {
namespace {

using Pair = std::pair<int, int>;

// What friction and rotors leave if the columns of two joints are exchanged.
double calc_left(const LoggedMotion& motion, const Pair& p) {
  const SampledMotion& rows = motion.rows;
  Eigen::MatrixXd q = rows.q, v = rows.v, a = rows.a;
  for (Eigen::MatrixXd* m : {&q, &v, &a}) m->col(p.first).swap(m->col(p.second));
  Eigen::MatrixXd tau = calc_efforts(motion.plant, q, v, a);
  tau.col(p.first).swap(tau.col(p.second));  // in the log's order
  return rows.calc_left(rows.effort - tau);
}

// The pair that leaves a detail of the mismatch.
std::optional<Pair> find_pair(const LoggedMotion& motion) {
  if (motion.share < kMuch * kMuch) return {};  // friction and rotors explain nearly all: the joints are in place
  std::vector<Pair> pairs;
  for (int i = 0; i < motion.rows.q.cols(); ++i) {
    for (int j = i + 1; j < motion.rows.q.cols(); ++j) pairs.emplace_back(i, j);
  }
  const std::optional<size_t> best =
      find_reading(motion, pairs.size(), [&](size_t i) { return calc_left(motion, pairs[i]); });
  return best ? std::optional(pairs[*best]) : std::nullopt;
}

Experiment exchange(Experiment e, const Pair& p) {
  for (Recording& r : e.recordings)
    std::swap(r.joints[static_cast<size_t>(p.first)], r.joints[static_cast<size_t>(p.second)]);
  std::swap(e.joint_noise[static_cast<size_t>(p.first)], e.joint_noise[static_cast<size_t>(p.second)]);
  return e;
}

}  // namespace

void check_exchanged_joints(const TorqueData& data, const LoggedMotion& motion, int jobs) {
  const Experiment& e = *data.experiment;
  const std::optional<Pair> pair = find_pair(motion);
  if (!pair) return;
  if (compare(fit_list(exchange(e, *pair), jobs), fit_list(make_torque_design(TorqueData(data)), jobs)) <
      kOneValue + kWholeGain)
    return;
  const std::string first = e.robot.tree.joint(pair->first).name, second = e.robot.tree.joint(pair->second).name;
  refuse_input(e.recordings.front().find_place(e.signal_name(pair->first, Quantity::kPosition)),
               "with its effort fits the model in the place of " + second + " only: are the columns of " + first +
                   " and " + second + " exchanged?");
}

}  // namespace hrp::diagnosis
