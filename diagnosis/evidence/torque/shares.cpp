// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque/shares.h"

#include <algorithm>

#include "diagnosis/estimate/shapley.h"

namespace hrp::diagnosis {
namespace {

struct ModelAtJoint {
  const TorqueDesign& design;
  const TorqueModel& model;
  const TorqueFit& fit;
  const Slots slots;
  size_t joint;
};

// Held-out mean square of a joint with the terms in `mask` (the players of a Shapley value). The joint's own terms
// are fitted to training again. Terms of the whole robot and gains keep their parameters: a gain fitted without
// friction would make the drive weaker instead, and its worth and that of friction would be those of another model.
double calc_held(const ModelAtJoint& m, size_t mask) {
  const JointDesign& joint = m.design.joints[m.joint];
  Columns columns, fixed;
  const size_t own = m.model.own[m.joint].size();
  std::vector<size_t> gains;
  Eigen::VectorXd values;
  const auto hold = [&](long slot, const Columns& at) {
    const long before = values.size(), size = static_cast<long>(at.size());
    fixed.insert(fixed.end(), at.begin(), at.end());
    values.conservativeResize(before + size);
    values.tail(size) = m.fit.theta.segment(slot, size);
  };
  for (size_t t = 0; t < own; ++t) {
    if (!(mask >> t & 1)) continue;
    const size_t term = m.model.own[m.joint][t];
    if (joint.terms[term].row->scales_effort) {
      hold(m.slots.own[m.joint][t], list_columns(joint, term));
      gains.push_back(term);
      continue;
    }
    for (long c : list_columns(joint, term)) columns.push_back(c);
  }
  const Eigen::VectorXd factor = values;
  for (size_t t = 0; t < m.model.whole.size(); ++t) {
    if (!(mask >> (own + t) & 1)) continue;
    hold(m.slots.whole[t], list_whole_columns(m.design, joint, m.model.whole[t]));
  }
  Gram total = joint.total;
  for (size_t f = 0; f < fixed.size(); ++f) {
    for (long c = 0; c < total.b.size(); ++c) total.b[c] -= joint.total.get(c, fixed[f]) * values[static_cast<long>(f)];
  }
  const Eigen::VectorXd theta = solve(total, columns);
  columns.insert(columns.end(), fixed.begin(), fixed.end());
  Eigen::VectorXd all(theta.size() + values.size());
  all << theta, values;
  double rest = 0.0, n = 0.0;
  for (const Gram& held : joint.held) {
    rest += calc_rest(held, columns, all);
    n += held.n;
  }
  return calc_per_effort(joint, gains, factor) * rest / std::max(1.0, n);
}

}  // namespace

std::vector<double> calc_term_shares(const TorqueDesign& design, const TorqueModel& model, const TorqueFit& fit,
                                     size_t joint) {
  const size_t players = model.own[joint].size() + model.whole.size();
  const ModelAtJoint m{design, model, fit, list_slots(design, model), joint};
  return calc_shapley(
      players, [&](size_t mask) { return -calc_held(m, mask); }, players);
}

}  // namespace hrp::diagnosis
