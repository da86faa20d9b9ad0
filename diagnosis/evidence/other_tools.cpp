// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/other_tools.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/slopes.h"
#include "diagnosis/evidence/plain_model.h"
#include "diagnosis/model/nominal.h"
#include "diagnosis/search/fit_residuals.h"
#include "diagnosis/search/subtrees.h"
#include "diagnosis/simulation/plant.h"
#include "diagnosis/simulation/windows.h"

namespace hrp::diagnosis {
namespace {

constexpr double kSlowest = 0.1;  // [rad/s] Stribeck velocity at the start of a fit
constexpr int kFewJoints = 2;     // with several starts

// Which parts a friction model has beside viscous and dry friction.
struct FrictionModel {
  const char* name;
  bool stribeck, load, direction;
};
constexpr FrictionModel kModels[] = {{"M1: Coulomb and viscous", false, false, false},
                                     {"M2: Stribeck", true, false, false},
                                     {"M3: load", false, true, false},
                                     {"M4: Stribeck and load", true, true, false},
                                     {"M5: Stribeck, load and its direction", true, true, true}};

void add_drive(const FrictionModel& model, const PlainDrive& from, int joint, Hypothesis* out) {
  if (model.stribeck) {
    out->push_back({EffectId::kStribeck, joint, {from.dry, (1.0 + kMuch) * from.dry, kSlowest, from.viscous, kStick}});
  } else {
    out->push_back({EffectId::kViscous, joint, {from.viscous}});
    out->push_back({EffectId::kCoulomb, joint, {from.dry, 0.0, kStick}});
  }
  if (model.load) out->push_back({EffectId::kLoadFriction, joint, {kMinor, kStick}});
  if (model.direction) out->push_back({find_effect("backdriving_friction")->id, joint, {kMinor, kStick}});
  out->push_back({EffectId::kRotorInertia, joint, {from.rotor}});
}

using Drives = std::vector<PlainDrive>;  // by joint

// Friction at the start: where least squares has none, next to none, because a fit needs a slope.
Hypothesis make_start(const FrictionModel& model, const Experiment& e, const Drives& drives) {
  Hypothesis out;
  for (int j = 0; j < e.num_joints(); ++j) {
    if (!e.robot.tree.joint(j).actuated) continue;
    PlainDrive drive = drives[static_cast<size_t>(j)];
    const double limit = e.robot.tree.joint(j).effort_limit;
    if (std::isfinite(limit)) drive.dry = std::max(drive.dry, kRelativeStep * limit);
    add_drive(model, drive, j, &out);
  }
  return out;
}

// The common part of all models, where the fit of a larger one may start.
Drives read_drives(const Hypothesis& h, int num_joints) {
  Drives out(static_cast<size_t>(num_joints));
  for (const Effect& effect : h) {
    PlainDrive& drive = out[static_cast<size_t>(effect.place.index)];
    if (effect.id == EffectId::kViscous) drive.viscous = effect.p[0];
    if (effect.id == EffectId::kCoulomb) drive.dry = effect.p[0];
    if (effect.id == EffectId::kStribeck) {
      drive.dry = effect.p[0];
      drive.viscous = effect.p[3];
    }
    if (effect.id == EffectId::kRotorInertia) drive.rotor = effect.p[0];
  }
  return out;
}

// None of these programs has friction that differs by direction.
Hypothesis make_symmetric(Hypothesis h) {
  for (Effect& effect : h) {
    if (effect.id == EffectId::kCoulomb) effect.p[1] = 0.0;
  }
  return h;
}

// Of the positions alone, which these programs compare. Efforts let a simulation drift away: there over short windows,
// each from the recorded state, as a user would cut the recording.
bool calc_position_residuals(const Problem& problem, const Hypothesis& h, int recording, std::vector<double>* out) {
  const Experiment& e = *problem.experiment;
  const size_t r = static_cast<size_t>(recording), width = problem.weights.size();
  const bool windows = is_effort_driven(e);
  const bool ok = windows ? simulate_windows(make_plant(e, h), e, problem.smooth[r], recording, out)
                          : calc_residuals(problem, h, recording, out);
  for (size_t i = 0; ok && i < out->size(); ++i) {
    const size_t channel = i % width;
    double& x = (*out)[i];
    if (channel % kQuantities != 0) x = 0.0;
    if (channel % kQuantities != 0 || !windows) continue;
    const std::vector<double>& q = e.recordings[r].joints[channel / kQuantities].signal[0];
    const double recorded = q.empty() ? std::nan("") : q[i / width];
    x = std::isfinite(recorded) ? (recorded - x) * problem.weights[channel] : 0.0;
  }
  return ok;
}

// From each start; the best fit, or the first start where no simulation stays finite.
Hypothesis fit_model(const FrictionModel& model, const Problem& problem, const std::vector<Drives>& starts) {
  const auto residuals = [&](const Hypothesis& h, int recording, std::vector<double>* out) {
    return calc_position_residuals(problem, make_symmetric(h), recording, out);
  };
  FitResult best;
  for (const Drives& drives : starts) {
    const Hypothesis start = make_start(model, *problem.experiment, drives);
    const FitResult result = fit(residuals, problem.jobs, start, problem.train, FitOptions{});
    if (best.hypothesis.empty()) best.hypothesis = start;
    if (result.ok && (!best.ok || result.train.chi2 < best.train.chi2)) best = result;
  }
  return make_symmetric(best.hypothesis);
}

// Plain least squares, and less of its friction: a drive that sticks in the simulation gives a fit no slope. Of a leg,
// a fit takes minutes, and joints that push each other hardly stick: one start.
std::vector<Drives> list_starts(const Problem& problem) {
  if (problem.experiment->num_joints() > kFewJoints) return {fit_plain_model(problem)};
  std::vector<Drives> starts(3, fit_plain_model(problem));
  for (PlainDrive& drive : starts[1]) drive.dry *= kMuch;
  for (PlainDrive& drive : starts[2]) {
    drive.dry *= kMuch;
    drive.viscous *= kMuch;
  }
  return starts;
}

// Each model also starts from the one before, of which it is an extension.
std::vector<OtherAnswer> fit_models(const Problem& problem) {
  const std::vector<Drives> usual = list_starts(problem);
  std::vector<Drives> starts = usual;
  std::vector<OtherAnswer> out;
  for (const FrictionModel& model : kModels) {
    out.push_back({model.name, fit_model(model, problem, starts)});
    starts = usual;
    starts.push_back(read_drives(out.back().hypothesis, problem.experiment->num_joints()));
  }
  return out;
}

}  // namespace

std::vector<OtherAnswer> fit_friction_models(const Problem& whole) {
  Problem problem = whole;
  split_subtrees(&problem);
  if (problem.subtrees.empty()) return fit_models(problem);
  std::vector<OtherAnswer> out;
  for (const Subtree& subtree : problem.subtrees) {
    const std::vector<OtherAnswer> own = fit_models(subtree.problem);
    out.resize(own.size());
    for (size_t i = 0; i < own.size(); ++i) {
      out[i].model = own[i].model;
      for (const Effect& effect : map_to_robot(own[i].hypothesis, subtree)) out[i].hypothesis.push_back(effect);
    }
  }
  return out;
}

}  // namespace hrp::diagnosis
