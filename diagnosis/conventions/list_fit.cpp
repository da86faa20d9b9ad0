// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/list_fit.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/evidence/torque/loads.h"

namespace hrp::diagnosis {

// Of an effort's squares: what leaves no more than a trace of the effort needs nothing beside it.
bool ListFit::is_exact() const {
  return std::all_of(cross.begin(), cross.end(), [](double left) { return left <= kTrace * kTrace; });
}

ListFit fit_list(const Experiment& e, int jobs, Of of) {
  TorqueData data = make_torque_data(e);
  return data.recordings.empty() ? ListFit{} : fit_list(make_torque_design(std::move(data)), jobs, of);
}

ListFit fit_list(const TorqueDesign& as_made, int jobs, Of of) {
  ListFit out;
  if (as_made.joints.empty()) return out;
  TorqueDesign design = as_made;
  const Choice choice = of == Of::kJoints ? choose_joint_terms(design, jobs) : choose_with_placed_loads(jobs, &design);
  for (size_t i = 0; i < design.joints.size(); ++i) {
    const JointDesign& joint = design.joints[i];
    out.cross.push_back(std::max(choice.fit.cross[i] * joint.weigh_squares(), kTrace * kTrace));
    out.effective.push_back(joint.effective);
    out.square.push_back(1.0 / joint.weigh_squares());
    for (size_t term : choice.model.own[i]) out.cost += joint.terms[term].row->cost;
  }
  for (size_t term : choice.model.whole) out.cost += design.whole[term].row->cost;
  return out;
}

double compare(const ListFit& a, const ListFit& b) {
  if (a.cross.size() != b.cross.size()) return -1e300;
  double nats = b.cost - a.cost;
  for (size_t i = 0; i < a.cross.size(); ++i)
    nats += 0.5 * std::min(a.effective[i], b.effective[i]) * std::log(b.cross[i] / a.cross[i]);
  return nats;
}

double compare_torques(const ListFit& a, const ListFit& b) {
  const auto in_torques = [](ListFit fit) {
    for (size_t i = 0; i < fit.cross.size(); ++i) fit.cross[i] *= fit.square[i];
    return fit;
  };
  return compare(in_torques(a), in_torques(b));
}

}  // namespace hrp::diagnosis
