// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque/loads.h"

#include <optional>
#include <set>

#include "diagnosis/estimate/rounds.h"
#include "diagnosis/evidence/gear_loads.h"
#include "diagnosis/evidence/soft_joints.h"

namespace hrp::diagnosis {
namespace {

constexpr double kMoved = 0.01;  // [m] smallest move: 10 % of the inertia of a load at 0.2 m

// The usual terms of all drives and one load.
TorqueModel make_load_model(const TorqueDesign& design, size_t load) { return {list_usual_terms(design), {load}}; }

// The model with a load in place of all terms for the mass of that link.
TorqueModel exchange_masses(const TorqueDesign& design, const TorqueModel& model, size_t load) {
  TorqueModel with{model.own, {}};
  for (size_t term : model.whole) {
    if (!design.whole[term].row->is_of_mass() || design.whole[term].place != design.whole[load].place)
      with.whole.push_back(term);
  }
  with.whole.push_back(load);
  return with;
}

// Position of the load that is the last term of the model; empty if the load is not physical.
std::optional<Vector3d> fit_place(const TorqueDesign& design, const TorqueModel& model) {
  const size_t load = model.whole.back();
  const Eigen::VectorXd all = fit_torque(design, model).theta.segment(list_slots(design, model).whole.back(), 4);
  if (!is_whole_physical(design, design.whole[load], all)) return std::nullopt;
  const Eigen::VectorXd p = drop_unseen(design, design.whole[load], all);
  return Vector3d(p.tail<3>() / p[0]);
}

// Moves the loads to the positions that the models give, and builds the design again. Each model ends with a load.
// Returns false, without any change, if no load moves by more than kMoved.
bool move_loads(const std::vector<TorqueModel>& models, TorqueDesign* design) {
  bool moved = false;
  TorqueData data = *design->data;
  for (const TorqueModel& model : models) {
    Vector3d& place = data.load_p_L[static_cast<size_t>(design->whole[model.whole.back()].place)];
    const std::optional<Vector3d> p = fit_place(*design, model);
    if (p && (*p - place).norm() > kMoved) {
      place = *p;
      moved = true;
    }
  }
  if (moved) *design = make_torque_design(std::move(data));
  return moved;
}

std::vector<size_t> list_loads(const TorqueDesign& design) {
  std::vector<size_t> loads;
  for (size_t t = 0; t < design.whole.size(); ++t) {
    if (design.whole[t].row->load) loads.push_back(t);
  }
  return loads;
}

// Places every load that is significant beside the usual terms. Returns as move_loads.
bool place_each_load(TorqueDesign* design) {
  std::vector<TorqueModel> models;
  const double without = fit_torque(*design, {list_usual_terms(*design), {}}).evidence;
  for (size_t load : list_loads(*design)) {
    const TorqueModel with = make_load_model(*design, load);
    if (fit_torque(*design, with).evidence > without + kWholeGain) models.push_back(with);
  }
  return move_loads(models, design);
}

// Places loads at the links whose mass the model changes, beside its other terms. Returns as move_loads.
bool place_loads(const TorqueModel& model, TorqueDesign* design) {
  std::set<int> links;
  for (size_t term : model.whole) {
    if (design->whole[term].row->is_of_mass()) links.insert(design->whole[term].place);
  }
  std::vector<TorqueModel> models;
  for (size_t load : list_loads(*design)) {
    if (links.count(design->whole[load].place)) models.push_back(exchange_masses(*design, model, load));
  }
  return move_loads(models, design);
}

}  // namespace

Choice choose_with_placed_loads(int jobs, TorqueDesign* design) {
  for (int i = 0; i < kFewRounds && place_each_load(design); ++i) {
  }
  Choice choice = choose_torque_model(*design, jobs);
  // The position is moment over mass. If the mass is hardly determined, a larger distance reduces the mass, which
  // increases the distance further. Therefore a step counts only if the evidence improves.
  for (int i = 0; i < kFewRounds; ++i) {
    TorqueDesign moved = *design;
    if (!place_loads(choice.model, &moved)) break;
    const Choice again = choose_torque_model(moved, jobs);
    if (!(again.fit.evidence > choice.fit.evidence)) break;
    *design = std::move(moved);
    choice = again;
  }
  soften_gears(jobs, design, &choice);
  TorqueDesign reloaded = *design;
  if (!reload_gears(choice.model, &reloaded)) return choice;
  Choice again = choose_torque_model(reloaded, jobs);
  if (calc_gain({reloaded, again.model, again.fit}, {*design, choice.model, choice.fit}) <= 0.0) return choice;
  *design = std::move(reloaded);
  return again;
}

}  // namespace hrp::diagnosis
