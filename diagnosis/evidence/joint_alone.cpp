// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/joint_alone.h"

#include <algorithm>

#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/search/nearby.h"

namespace hrp::diagnosis {
namespace {

constexpr double kCoarse = 2.0;  // times the usual integration step; enough for one joint

template <typename Keep>
Hypothesis take(const Hypothesis& model, Keep keep) {
  Hypothesis out;
  std::copy_if(model.begin(), model.end(), std::back_inserter(out), keep);
  return out;
}

}  // namespace

bool is_of_joint(const Effect& effect) {
  return effect.place.kind == PlaceKind::kJoint || effect.place.kind == PlaceKind::kSensor;
}

bool is_at(const Effect& effect, int joint) { return is_of_joint(effect) && effect.place.index == joint; }

Hypothesis take_joint(const Hypothesis& model, int joint) {
  return take(model, [joint](const Effect& e) { return is_at(e, joint); });
}

Hypothesis take_links(const Hypothesis& model) {
  return take(model, [](const Effect& e) { return !is_of_joint(e); });
}

JointPaths::JointPaths(const Problem& problem, const Hypothesis& links) : along_(problem) {
  along_.view = {};
  along_.subtrees.clear();
  if (along_.nominal_paths.empty()) prepare_paths(&along_);
  paths_ = make_paths(along_, links);
}

Problem JointPaths::view(int joint) const {
  Problem one = along_;
  one.jobs = 1;
  one.options.max_step *= kCoarse;
  one.view = {true, &paths_, joint};
  return one;
}

JointAlone::JointAlone(const JointPaths& paths, int joint)
    : problem(paths.view(joint)), residuals(make_residuals(problem)) {}

FitResult JointAlone::fit(const Hypothesis& start, int iterations, const std::vector<int>& recordings) const {
  FitOptions options;
  options.max_iterations = iterations;
  options.tolerance = kAgreement;
  return diagnosis::fit(residuals, 1, start, recordings, options);
}

Hypothesis JointAlone::fit_to_the_end(const Hypothesis& start) const {
  FitResult best = fit(start, kRounds);
  if (!best.ok) return {};
  for (int round = 0; round < kFewRounds; ++round) {
    const FitResult again = fit(try_nearby(problem, best.hypothesis, kCoarseFactor), kRounds);
    if (!again.ok || again.train.chi2 >= best.train.chi2) break;
    const bool settled = again.train.chi2 > (1.0 - kTrace) * best.train.chi2;
    best = again;
    if (settled) break;
  }
  const Score before = score(start);
  return before.ok && before.chi2 <= best.train.chi2 ? Hypothesis{} : best.hypothesis;
}

CalcResiduals make_residuals(const Problem& problem) {
  return [&problem](const Hypothesis& h, int recording, std::vector<double>* out) {
    return calc_residuals(problem, h, recording, out);
  };
}

}  // namespace hrp::diagnosis
