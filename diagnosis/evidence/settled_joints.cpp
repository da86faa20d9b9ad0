// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/settled_joints.h"

#include <algorithm>

#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis {
namespace {

// Squares of a joint's signals over the noise, of all held-out recordings.
double sum_squares(const Score& score, int joint) {
  double sum = 0.0;
  for (size_t q = 0; q < kQuantities; ++q) {
    const size_t c = static_cast<size_t>(joint) * kQuantities + q;
    if (c < score.signal_chi2.size()) sum += score.signal_chi2[c];
  }
  return sum;
}

bool is_settled(const Experiment& e, const Effect& effect, const Trial& trial, const Trial& nominal,
                const std::vector<Finding>& found) {
  if (effect.place.kind != PlaceKind::kJoint) return false;
  const int joint = effect.place.index;
  const Where where{{"joint", e.robot.tree.joint(joint).name}};
  const bool named = std::any_of(found.begin(), found.end(), [&](const Finding& f) {
    return f.grade == Grade::kSupported && f.effect == get_effect(effect.id).name && f.where == where;
  });
  const double before = sum_squares(nominal.validate, joint);
  return named && before > 0.0 && sum_squares(trial.validate, joint) < kTrace * before;
}

}  // namespace

std::optional<Outcome> name_settled_joints(const Problem& problem, const Outcome& outcome,
                                           const std::vector<Finding>& found) {
  const Trial* best = nullptr;
  for (const Trial& t : outcome.rivals) {
    const bool complete = t.refined && t.std.size() >= t.hypothesis.size() && t.validate.ok;
    if (!complete || t.hypothesis.size() <= (best ? best->hypothesis.size() : 0)) continue;
    const bool settled = std::all_of(t.hypothesis.begin(), t.hypothesis.end(), [&](const Effect& effect) {
      return is_settled(*problem.experiment, effect, t, outcome.nominal, found);
    });
    if (settled) best = &t;
  }
  if (!best || problem.validate.empty()) return std::nullopt;
  Outcome named = outcome;
  named.chosen = *best;
  named.chosen.probability = kNearlyAll;
  named.indistinguishable.clear();
  named.partly = true;
  return named;
}

}  // namespace hrp::diagnosis
