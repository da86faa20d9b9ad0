// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque/misleading.h"

#include <algorithm>
#include <cmath>

#include "common/base/has.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/torque/subsets.h"
#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {
namespace {

struct Suspect {
  const TermRow* row = nullptr;  // null: no term misleads
  double held = 0.0;             // [(N m)^2] held-out mean square without it
};

// The joint's term whose removal improves the held-out prediction most, with all other terms fitted again.
Suspect find_misleading(const TorqueDesign& design, const Choice& choice, size_t i) {
  Suspect worst{nullptr, (1.0 - kMinor) * choice.fit.held[i]};
  // Smoothing leaves as much even with a perfect model: below it, no term misleads.
  if (worst.held < std::pow(kTrace * design.joints[i].spread, 2)) return worst;
  for (size_t t = 0; t < choice.model.own[i].size(); ++t) {
    TorqueModel rest = choice.model;
    rest.own[i].erase(rest.own[i].begin() + static_cast<long>(t));
    const double held = fit_torque(design, rest).held[i];
    if (held < worst.held) worst = {design.joints[i].terms[choice.model.own[i][t]].row, held};
  }
  return worst;
}

// Bars one more row at each joint with a misleading term. Returns false if there is none.
bool bar_rows(int jobs, const Choice& choice, TorqueDesign* design) {
  std::vector<Suspect> suspects(design->joints.size());
  parallel_for(jobs, static_cast<int>(suspects.size()), [&](int i) {
    suspects[static_cast<size_t>(i)] = find_misleading(*design, choice, static_cast<size_t>(i));
  });
  bool any = false;
  for (size_t i = 0; i < suspects.size(); ++i) {
    if (suspects[i].row) {
      design->joints[i].barred.push_back(suspects[i].row);
      any = true;
    }
  }
  return any;
}

// Of every joint.
std::vector<size_t> count_barred(const TorqueDesign& design) {
  std::vector<size_t> counts;
  for (const JointDesign& joint : design.joints) counts.push_back(joint.barred.size());
  return counts;
}

void bar_only_first(const std::vector<size_t>& counts, TorqueDesign* design) {
  for (size_t i = 0; i < counts.size(); ++i) design->joints[i].barred.resize(counts[i]);
}

// Allows the last barred row again at joints where the new choice predicts no better. Returns false if there is none.
bool allow_again(const Choice& before, const Choice& after, const std::vector<size_t>& barred, TorqueDesign* design) {
  bool any = false;
  for (size_t i = 0; i < barred.size(); ++i) {
    std::vector<const TermRow*>& own = design->joints[i].barred;
    if (own.size() == barred[i] || after.fit.held[i] < (1.0 - kMinor) * before.fit.held[i]) continue;
    own.pop_back();
    any = true;
  }
  return any;
}

// Score [nats] of a model: its evidence on the training recordings plus its log-likelihood on the held-out recordings.
// Their independent samples are taken as dense as those of training.
double calc_score(const TorqueDesign& design, const TorqueFit& fit) {
  double score = fit.evidence;
  for (size_t i = 0; i < design.joints.size(); ++i) {
    const JointDesign& joint = design.joints[i];
    double held = 0.0;
    for (const Gram& recording : joint.held) held += recording.n;
    const double independent = joint.effective * held / std::max(1.0, joint.total.n);
    const double floor = kFloor * joint.spread * joint.spread;
    score -= 0.5 * independent * std::log(std::max({fit.held[i], floor, 1e-300}));
  }
  return score;
}

// Models in which another zero stands in the place of `term` of joint i: one of the joint, or of the whole robot.
std::vector<TorqueModel> list_exchanges(const TorqueDesign& design, const TorqueModel& without, size_t i, size_t term) {
  std::vector<TorqueModel> models;
  for (size_t t = 0; t < design.joints[i].terms.size(); ++t) {
    TorqueModel model = without;
    std::vector<size_t>& own = model.own[i];
    if (t == term || has(own, t) || !design.joints[i].terms[t].row->is_like_zero()) continue;
    own.insert(std::lower_bound(own.begin(), own.end(), t), t);
    if (is_sensible(design.joints[i], own)) models.push_back(std::move(model));
  }
  for (size_t t = 0; t < design.whole.size(); ++t) {
    if (design.whole[t].effect().family != EffectFamily::kZero || has(without.whole, t)) continue;
    models.push_back(without);
    models.back().whole.push_back(t);
  }
  return models;
}

// The best exchange of one zero of joint i that held-out recordings do not want. All recordings together make it as
// likely, up to odds of 20 to 1; it predicts held-out recordings clearly better, and better than no term.
bool exchange_zero(const TorqueDesign& design, int jobs, size_t i, Choice* choice) {
  for (size_t at = 0; at < choice->model.own[i].size(); ++at) {
    const size_t term = choice->model.own[i][at];
    if (!design.joints[i].terms[term].row->is_like_zero()) continue;
    TorqueModel without = choice->model;
    without.own[i].erase(without.own[i].begin() + static_cast<long>(at));
    const double held = fit_torque(design, without).held[i];
    if (held > choice->fit.held[i]) continue;
    const std::vector<TorqueModel> models = list_exchanges(design, without, i, term);
    std::vector<TorqueFit> fits(models.size());
    parallel_for(jobs, static_cast<int>(models.size()),
                 [&](int m) { fits[static_cast<size_t>(m)] = fit_torque(design, models[static_cast<size_t>(m)]); });
    const double least = calc_score(design, choice->fit) - kOdds,
                 most_held = std::min(held, (1.0 - kMinor) * choice->fit.held[i]);
    size_t best = models.size();
    double most = 0.0;  // its score
    for (size_t m = 0; m < models.size(); ++m) {
      const double score = calc_score(design, fits[m]);
      if (score < least || fits[m].held[i] > most_held || !is_model_physical(design, models[m], fits[m])) continue;
      if (best == models.size() || score > most) {
        best = m;
        most = score;
      }
    }
    if (best == models.size()) continue;
    choice->model = models[best];
    choice->fit = fits[best];
    return true;
  }
  return false;
}

}  // namespace

void exchange_misleading_zeros(const TorqueDesign& design, int jobs, Choice* choice) {
  if (!design.has_held) return;
  for (size_t i = 0; i < design.joints.size(); ++i) exchange_zero(design, jobs, i, choice);
}

void drop_misleading_terms(int jobs, Timing timing, TorqueDesign* design, Choice* choice) {
  for (bool better = design->has_held; better;) {
    const std::vector<size_t> barred = count_barred(*design);
    if (!bar_rows(jobs, *choice, design)) return;
    Choice with = choose_torque_model(*design, jobs, timing);
    const bool undone = allow_again(*choice, with, barred, design);
    if (undone) with = choose_torque_model(*design, jobs, timing);
    better = calc_score(*design, with.fit) > calc_score(*design, choice->fit);
    if (better)
      *choice = with;
    else
      bar_only_first(barred, design);
    if (undone) return;
  }
}

bool drop_false_gains(int jobs, const std::vector<GradedTerm>& graded, TorqueDesign* design, Choice* choice) {
  const std::vector<size_t> barred = count_barred(*design);
  bool any = false;
  for (const GradedTerm& g : graded) {
    if (!g.term.row->scales_effort || g.place.joint < 0 || g.named || g.helps_held) continue;
    design->joints[static_cast<size_t>(g.place.joint)].barred.push_back(g.term.row);
    any = true;
  }
  if (!any) return false;
  Choice without = choose_torque_model(*design, jobs);
  drop_misleading_terms(jobs, Timing::kFree, design, &without);
  without.fit = fit_torque(*design, without.model);
  if (calc_held_left(*design, without.fit) > calc_held_left(*design, choice->fit)) {
    bar_only_first(barred, design);
    return false;
  }
  *choice = without;
  return true;
}

}  // namespace hrp::diagnosis
