// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque_loads.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

namespace hrp::diagnosis {
namespace {

constexpr int kPlacings = 2;     // of a load, whose inertia follows from where it hangs
constexpr double kMoved = 0.01;  // [m]: 10 % of the inertia of a load at 0.2 m

// What every drive has, and one load of the whole robot.
TorqueModel make_load_model(const TorqueDesign& design, size_t load) {
  return {list_usual_terms(design), {load}};
}

// The same model with a load in the place of all that it has of the link's mass.
TorqueModel exchange_masses(const TorqueDesign& design, const TorqueModel& model, size_t load) {
  TorqueModel with{model.own, {}};
  for (size_t term : model.whole) {
    if (!design.whole[term].row->is_of_mass() || design.whole[term].place != design.whole[load].place) with.whole.push_back(term);
  }
  with.whole.push_back(load);
  return with;
}

// Where the last term of a model, a load, hangs.
std::optional<Vector3d> fit_place(const TorqueDesign& design, const TorqueModel& model) {
  const size_t load = model.whole.back();
  const Eigen::VectorXd all = fit_torque(design, model).theta.segment(list_slots(design, model).whole.back(), 4);
  if (!is_whole_physical(design, design.whole[load], all)) return std::nullopt;
  const Eigen::VectorXd p = drop_unseen(design, design.whole[load], all);
  return Vector3d(p.tail<3>() / p[0]);
}

// Loads of the given models, each of which has one at its end.
bool move_loads(const std::vector<TorqueModel>& models, TorqueDesign* design) {
  bool moved = false;
  TorqueData data = *design->data;
  for (const TorqueModel& model : models) {
    Vector3d& place = data.load_p_L[static_cast<size_t>(design->whole[model.whole.back()].place)];
    const std::optional<Vector3d> p = fit_place(*design, model);
    if (p && (*p - place).norm() > kMoved) place = *p, moved = true;
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

// Every load where it hangs alone; false, and nothing changed, if none moves by more than a hand's width tells.
bool place_each_load(TorqueDesign* design) {
  std::vector<TorqueModel> models;
  const double without = fit_torque(*design, {list_usual_terms(*design), {}}).evidence;
  for (size_t load : list_loads(*design)) {
    const TorqueModel with = make_load_model(*design, load);
    if (fit_torque(*design, with).evidence > without + kWholeGain) models.push_back(with);
  }
  return move_loads(models, design);
}

// Loads of the links whose mass is in question in a model, beside all else that it has; as above.
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
  for (int i = 0; i < kPlacings && place_each_load(design); ++i) {
  }
  Choice choice = choose_torque_model(*design, jobs);
  // A place is the moment over the mass. Where the mass hardly shows, a place further out takes mass away, and that puts
  // the place still further out: only what fits better is a step.
  for (int i = 0; i < kPlacings; ++i) {
    TorqueDesign moved = *design;
    if (!place_loads(choice.model, &moved)) break;
    const Choice again = choose_torque_model(moved, jobs);
    if (!(again.fit.evidence > choice.fit.evidence)) break;
    *design = std::move(moved), choice = again;
  }
  return choice;
}

}  // namespace hrp::diagnosis
