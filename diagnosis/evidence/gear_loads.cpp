// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/gear_loads.h"

#include <algorithm>

#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis {
namespace {

// [nats] of a model: its terms, with the sizes of those that are factors.
double calc_cost(const FittedModel& m) {
  double of_errors = 0.0;
  for (size_t i = 0; i < m.design.joints.size(); ++i) of_errors += calc_evidence(m.design.joints[i], m.fit.cross[i]);
  return of_errors - m.fit.evidence;
}

// Cross-validated mean square of a joint in units of its effort [(N m)^2]. Where the effort itself is the load,
// friction mu |y| s takes mu of whatever drives the joint, errors included: 1 - mu of them are left.
double calc_square(const FittedModel& m, size_t i) {
  const JointDesign& joint = m.design.joints[i];
  if (!m.design.data->loaded_by_drive[static_cast<size_t>(joint.joint)]) return m.fit.cross[i];
  const Slots slots = list_slots(m.design, m.model);
  double mu = 0.0;
  for (size_t t = 0; t < m.model.own[i].size(); ++t) {
    if (joint.terms[m.model.own[i][t]].row->by_load) mu = m.fit.theta[slots.own[i][t]];
  }
  // Of a gear that gives nothing, nothing is divided by it.
  const double left = std::max(kAgreement, 1.0 - std::max(0.0, mu));
  return m.fit.cross[i] / (left * left);
}

// Loads of the joint by the recorded effort.
void load_by_effort(int joint, TorqueData* data) {
  data->loaded_by_drive[static_cast<size_t>(joint)] = true;
  for (TorqueRecording& r : data->recordings) r.load.col(joint) = r.effort.col(joint);
}

// The model with friction of the load at a joint; empty lists if the joint has no such term.
TorqueModel add_loaded_friction(const TorqueDesign& design, TorqueModel model, size_t i) {
  const std::vector<Term>& terms = design.joints[i].terms;
  std::vector<size_t>& own = model.own[i];
  const auto has = [&](size_t t) { return terms[t].row->by_load; };
  if (std::any_of(own.begin(), own.end(), has)) return model;
  for (size_t t = 0; t < terms.size(); ++t) {
    if (!has(t)) continue;
    own.insert(std::upper_bound(own.begin(), own.end(), t), t);
    return model;
  }
  return {};
}

// [nats] by which a joint's mean square is better.
double calc_joint_gain(const FittedModel& a, const FittedModel& b, size_t i) {
  const JointDesign &of_a = a.design.joints[i], &of_b = b.design.joints[i];
  const JointDesign& fewer = of_a.effective < of_b.effective ? of_a : of_b;
  return calc_evidence(fewer, calc_square(a, i)) - calc_evidence(fewer, calc_square(b, i));
}

}  // namespace

double calc_gain(const FittedModel& a, const FittedModel& b) {
  double nats = calc_cost(b) - calc_cost(a);
  for (size_t i = 0; i < a.design.joints.size(); ++i) nats += calc_joint_gain(a, b, i);
  return nats;
}

bool reload_gears(const TorqueModel& model, TorqueDesign* design) {
  TorqueData all = *design->data;
  for (const JointDesign& joint : design->joints) load_by_effort(joint.joint, &all);
  const TorqueDesign by_effort = make_torque_design(std::move(all));
  if (by_effort.joints.size() != design->joints.size()) return false;
  const TorqueFit without = fit_torque(*design, model);
  TorqueData data = *design->data;
  bool any = false;
  for (size_t i = 0; i < design->joints.size(); ++i) {
    const TorqueModel with = add_loaded_friction(by_effort, model, i);
    if (with.own.empty()) continue;
    const TorqueFit fit = fit_torque(by_effort, with);
    const double cost = with.own[i].size() > model.own[i].size() ? find_term_row(&TermRow::by_load).cost : 0.0;
    const double gain = calc_joint_gain({by_effort, with, fit}, {*design, model, without}, i) - cost;
    if (gain > 0.0 && is_model_physical(by_effort, with, fit)) {
      load_by_effort(design->joints[i].joint, &data);
      any = true;
    }
  }
  if (any) *design = make_torque_design(std::move(data));
  return any;
}

}  // namespace hrp::diagnosis
