// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/polish.h"

#include <algorithm>

#include "diagnosis/search/fit.h"
#include "diagnosis/search/nearby.h"

namespace hrp::diagnosis {
namespace {

constexpr int kIterations = 10;
constexpr double kTolerance = 1e-3;
constexpr double kCoarse = 2.0;     // times the usual step: one joint alone
constexpr double kFinest = 1.5;     // factor to which displacements before slipping are walked

// Of a joint's drive, or of the readings of its drive.
bool is_of_joint(const Effect& effect) {
  return find_place_kind(effect.id) == PlaceKind::kJoint || find_place_kind(effect.id) == PlaceKind::kSensor;
}

bool is_at(const Effect& effect, int joint) {
  if (find_place_kind(effect.id) == PlaceKind::kSensor) return effect.place / kQuantities == joint;
  return is_of_joint(effect) && effect.place == joint;
}

// One joint's effects, fitted; empty where no rollout stays finite.
Hypothesis fit_joint(const Problem& problem, const Hypothesis& start) {
  FitOptions options;
  options.max_iterations = kIterations;
  options.tolerance = kTolerance;
  const FitResult first = fit(problem, start, problem.train, options);
  if (!first.ok) return {};
  const FitResult again = fit(problem, try_nearby(problem, first.hypothesis, kFinest), problem.train, options);
  const FitResult& best = again.ok && again.train.chi2 < first.train.chi2 ? again : first;
  const Score before = calc_score(problem, start, problem.train);
  return before.ok && before.chi2 <= best.train.chi2 ? Hypothesis{} : best.hypothesis;
}

}  // namespace

Hypothesis split_asymmetry(const Hypothesis& model) {
  Hypothesis out = model;
  const EffectId constant = find_effect("constant_torque")->id;
  for (const Effect& dry : model) {
    if (dry.id != EffectId::kCoulomb || dry.p[1] == 0.0) continue;
    const auto there = std::find_if(out.begin(), out.end(), [&](const Effect& e) { return e.id == constant && e.place == dry.place; });
    if (there != out.end()) there->p[0] += dry.p[0] * dry.p[1];
    else out.push_back({constant, dry.place, {dry.p[0] * dry.p[1]}});
  }
  for (Effect& effect : out) {
    if (effect.id == EffectId::kCoulomb) effect.p[1] = 0.0;
  }
  return out;
}

Hypothesis polish_joints(const Problem& problem, const Hypothesis& model) {
  Problem along = problem;
  along.view = {}, along.subtrees.clear();
  if (along.nominal_paths.empty()) prepare_paths(&along);
  Hypothesis links;
  for (const Effect& effect : model) {
    if (!is_of_joint(effect)) links.push_back(effect);
  }
  const Paths paths = make_paths(along, links);
  const int n = problem.experiment->num_joints();
  std::vector<Hypothesis> fitted(static_cast<size_t>(n));
  parallel_for(problem.jobs, n, [&](int j) {
    Hypothesis own;
    for (const Effect& effect : model) {
      if (is_at(effect, j)) own.push_back(effect);
    }
    if (own.empty()) return;
    Problem alone = along;
    alone.jobs = 1;
    alone.options.max_step *= kCoarse;
    alone.view = {true, &paths, j};
    fitted[static_cast<size_t>(j)] = fit_joint(alone, own);
  });
  Hypothesis out = links;
  for (int j = 0; j < n; ++j) {
    const Hypothesis& own = fitted[static_cast<size_t>(j)];
    if (!own.empty()) {
      out.insert(out.end(), own.begin(), own.end());
      continue;
    }
    for (const Effect& effect : model) {
      if (is_at(effect, j)) out.push_back(effect);
    }
  }
  return split_asymmetry(out);
}

}  // namespace hrp::diagnosis
