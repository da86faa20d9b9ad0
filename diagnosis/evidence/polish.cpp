// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/polish.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/search/fit.h"
#include "diagnosis/search/nearby.h"

namespace hrp::diagnosis {
namespace {

constexpr int kIterations = 10;
constexpr double kTolerance = 1e-3;
constexpr double kCoarse = 2.0;     // times the usual step: one joint alone
constexpr double kFinest = 1.5;     // factor to which displacements before slipping are walked
constexpr double kWorth = 0.03;     // of the squares that a joint leaves, which one more law must take away
constexpr int kMostAdded = 2;       // laws at one joint
constexpr int kTryIterations = 3;
constexpr double kQuiet = 1.2;      // times its noise (squares) below which a joint gets no more laws
constexpr double kInstant = 0.003;  // [s] that lags and delays start from
constexpr double kShareOfFastest[] = {0.05, 0.2};  // at which friction has come down to its level, of the fastest motion
constexpr int kWholeIterations = 3;
// Parameters x samples x joints^2 of one step through the whole robot: some seconds of one core.
constexpr double kMostWhole = 4e7;

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

// [rad/s]
double find_fastest(const Problem& problem, int joint) {
  double fastest = 0.0;
  for (int r : problem.train) {
    for (double v : problem.smooth[static_cast<size_t>(r)].joints[static_cast<size_t>(joint)].qd)
      fastest = std::max(fastest, std::abs(v));
  }
  return fastest;
}

Hypothesis with(Hypothesis own, const Effect& added) {
  own.push_back(added);
  return own;
}

// The model of a joint with one more law, or a richer one in the place of a plain one.
std::vector<Hypothesis> list_enriched(const Hypothesis& own, int joint, double fastest) {
  std::vector<Hypothesis> list;
  for (size_t i = 0; i < own.size(); ++i) {
    if (own[i].id != EffectId::kCoulomb) continue;
    for (double share : kShareOfFastest) {
      list.push_back(own);
      list.back()[i] = {EffectId::kStribeck, joint, {own[i].p[0], 1.2 * own[i].p[0], share * fastest, 0.0, own[i].p.back()}};
    }
  }
  const auto has = [&](EffectId id) { return contains(own, id, joint); };
  const bool timed = has(EffectId::kLag) || has(EffectId::kDelay);
  if (!timed) list.push_back(with(own, {EffectId::kLag, joint, {kInstant}}));
  if (!timed) list.push_back(with(own, {EffectId::kDelay, joint, {kInstant}}));
  if (!has(EffectId::kTorqueConstant)) list.push_back(with(own, {EffectId::kTorqueConstant, joint, {1.0}}));
  return list;
}

Hypothesis enrich(const Problem& alone, Hypothesis own, int joint) {
  FitOptions options;
  options.max_iterations = kTryIterations;
  options.tolerance = kTolerance;
  const double fastest = find_fastest(alone, joint);
  const Score before = calc_score(alone, own, alone.train);
  double least = before.chi2;
  if (!before.ok || least < kQuiet * before.count) return own;
  for (int round = 0; round < kMostAdded; ++round) {
    Hypothesis best;
    double limit = (1.0 - kWorth) * least;
    for (const Hypothesis& h : list_enriched(own, joint, fastest)) {
      const FitResult tried = fit(alone, h, alone.train, options);
      if (tried.ok && tried.train.chi2 < limit) best = tried.hypothesis, limit = tried.train.chi2;
    }
    if (best.empty()) break;
    own = best, least = limit;
  }
  const Hypothesis fitted = fit_joint(alone, own);
  return fitted.empty() ? own : fitted;
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

Hypothesis polish_joints(const Problem& problem, const Hypothesis& model, bool enriched) {
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
    Hypothesis& best = fitted[static_cast<size_t>(j)];
    best = enriched ? enrich(alone, own, j) : fit_joint(alone, own);
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

Hypothesis polish_whole(const Problem& problem, const Hypothesis& model) {
  double samples = 0.0, parameters = 0.0;
  for (int r : problem.train) samples += static_cast<double>(problem.experiment->recordings[static_cast<size_t>(r)].size());
  for (const Effect& e : model) parameters += static_cast<double>(e.p.size());
  if (parameters * samples * std::pow(problem.experiment->num_joints(), 2) > kMostWhole) return model;
  FitOptions options;
  options.max_iterations = kWholeIterations;
  options.tolerance = kTolerance;
  const FitResult result = fit(problem, model, problem.train, options);
  return result.ok ? split_asymmetry(result.hypothesis) : model;
}

}  // namespace hrp::diagnosis
